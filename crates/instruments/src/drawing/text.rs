//! Numbers and markup as people and browsers read them.

/// Text with the characters that mean something in HTML and XML replaced, and those that XML does
/// not allow.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => out.push(char::REPLACEMENT_CHARACTER),
            c if c.is_control() => out.push(char::REPLACEMENT_CHARACTER),
            c => out.push(c),
        }
    }
    out
}

/// A number to three digits.
pub fn number(x: f64) -> String {
    if !x.is_finite() {
        return "∞".to_owned();
    }
    let size = x.abs();
    if size <= 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&size) {
        let exponent = size.log10().floor() as i32;
        format!(
            "{:.2}·10{}",
            x / 10_f64.powi(exponent),
            superscript(exponent)
        )
    } else if size >= 100.0 {
        grouped(x)
    } else if size >= 10.0 {
        format!("{x:.1}")
    } else if size >= 1.0 {
        format!("{x:.2}")
    } else {
        let digits = (2.0 - size.log10().floor()) as usize;
        format!("{x:.digits$}")
    }
}

/// A power of ten as such, other numbers to three digits.
pub fn short(x: f64) -> String {
    let exponent = x.log10().round();
    if x > 0.0 && (x.log10() - exponent).abs() < 1e-12 && exponent.abs() > 1.5 {
        return format!("10{}", superscript(exponent as i32));
    }
    number(x)
}

/// A whole number with commas.
pub fn grouped(x: f64) -> String {
    let digits = format!("{:.0}", x.abs());
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    if x < 0.0 { format!("−{out}") } else { out }
}

/// Characters and how they look as superscripts.
pub const SUPERSCRIPTS: [(char, char); 11] = [
    ('−', '⁻'),
    ('0', '⁰'),
    ('1', '¹'),
    ('2', '²'),
    ('3', '³'),
    ('4', '⁴'),
    ('5', '⁵'),
    ('6', '⁶'),
    ('7', '⁷'),
    ('8', '⁸'),
    ('9', '⁹'),
];

/// A whole number as a superscript.
pub fn superscript(n: i32) -> String {
    let text = n.to_string().replace('-', "−");
    let raise = |c: char| {
        let found = SUPERSCRIPTS.iter().find(|s| s.0 == c);
        found.map_or(c, |s| s.1)
    };
    text.chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.01234, "0.0123"),
            (0.5, "0.500"),
            (3.144, "3.14"),
            (31.44, "31.4"),
            (1234.5, "1,234"),
            (123_456.0, "123,456"),
            (2.5e-5, "2.50·10⁻⁵"),
            (4.2e7, "4.20·10⁷"),
            (f64::INFINITY, "∞"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn powers_of_ten_are_short() {
        assert_eq!(short(1e-3), "10⁻³");
        assert_eq!(short(2e-3), "0.00200");
        assert_eq!(short(1.0), "1.00");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(
            escape("<a href='x'>&\""),
            "&lt;a href=&#39;x&#39;&gt;&amp;&quot;"
        );
    }
}
