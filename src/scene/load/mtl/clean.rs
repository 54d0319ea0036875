//! The text of a material library as the crate `tobj` reads it.
//!
//! The crate ends at a colour of one number, at one given as a spectrum or in XYZ, at a map or a
//! material without a name and at a comment behind data, and takes keywords as they are usually
//! written alone.

use crate::error::InputError;
use crate::scene::load::text;
use std::path::Path;

/// Keywords as the crate and [`super::convert`] know them. Of these, colours come first, then
/// numbers, then maps.
const KEYWORDS: [&str; 38] = [
    "Ka",
    "Kd",
    "Ks",
    "Ke",
    "Tf",
    "Ns",
    "Ni",
    "d",
    "Tr",
    "Pr",
    "Pm",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
    "anisor",
    "illum",
    "sharpness",
    "map_Ka",
    "map_Kd",
    "map_Ks",
    "map_Ke",
    "map_Ns",
    "map_d",
    "map_Tr",
    "map_Pr",
    "map_Pm",
    "map_Ps",
    "map_bump",
    "map_refl",
    "map_disp",
    "bump",
    "norm",
    "disp",
    "decal",
    "refl",
    "map_aat",
    "newmtl",
];
const COLORS: usize = 5;
const NUMBERS: usize = 18;

/// The statements of `text`, the library `file`.
pub(super) fn clean(file: &Path, text: &str) -> Result<String, InputError> {
    let mut clean = String::with_capacity(text.len());
    let mut unnamed = 0;
    for (number, line) in (1..).zip(text::lines(text)) {
        let line = line.trim();
        let Some(word) = line.split_whitespace().next() else {
            continue;
        };
        if word.starts_with('#') {
            continue;
        }
        let rest = line[word.len()..].trim();
        let known = KEYWORDS.iter().position(|k| k.eq_ignore_ascii_case(word));
        let keyword = known.map_or(word, |index| KEYWORDS[index]);
        let statement = match known {
            Some(index) if index < NUMBERS => numbers(rest, index < COLORS),
            _ if keyword == "newmtl" && rest.is_empty() => {
                unnamed += 1;
                Some(format!("unnamed {unnamed}"))
            }
            _ => Some(rest.to_owned()),
        };
        let statement = statement.ok_or_else(|| {
            let problem = format!("is `{line}`");
            let expected = if known.is_some_and(|index| index < COLORS) {
                "three numbers, or one"
            } else {
                "a number"
            };
            InputError::new(
                file,
                format!("line {number}"),
                problem,
                format!("`{keyword}` and {expected}"),
            )
        })?;
        if statement.is_empty() {
            continue;
        }
        // A keyword that `convert` names as ignored: a spectrum, or XYZ.
        let other = known.is_some_and(|i| i < COLORS) && statement.starts_with(['s', 'x']);
        clean += if other { "spectral" } else { keyword };
        clean.push(' ');
        clean += &statement;
        clean.push('\n');
    }
    Ok(clean)
}

/// The numbers of `rest` in their usual spelling, of a colour three; a colour that is given
/// otherwise as it is. `None` where they are none.
fn numbers(rest: &str, is_color: bool) -> Option<String> {
    let mut words = rest.split_whitespace().take_while(|w| !w.starts_with('#'));
    let first = match words.next() {
        None => return Some(String::new()),
        Some("-halo") => words.next()?,
        Some("spectral" | "xyz") if is_color => return Some(rest.to_owned()),
        Some(first) => first,
    };
    let number = |word: &str| text::number(word).filter(|n| n.is_finite());
    let first = number(first)?;
    if !is_color {
        return Some(first.to_string());
    }
    let rest: Option<Vec<f64>> = words.map(number).collect();
    match *rest?.as_slice() {
        [] => Some(format!("{first} {first} {first}")),
        [second, third, ..] => Some(format!("{first} {second} {third}")),
        [_] => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_as_the_crate_reads_them() {
        let text = "# a library\r\nNEWMTL red brick #2\n kd 0.5\nKs .1 1.e-1 1d-1 # shiny\nKe spectral a.rfl\nd -halo 0.25\nMAP_kd wood 1.png\nmap_Bump\nnewmtl\nfoo bar\n";
        assert_eq!(
            clean(Path::new("a.mtl"), text).expect("statements"),
            "newmtl red brick #2\nKd 0.5 0.5 0.5\nKs 0.1 0.1 0.1\nspectral spectral a.rfl\nd 0.25\nmap_Kd wood 1.png\nnewmtl unnamed 1\nfoo bar\n"
        );
    }

    #[test]
    fn bad_numbers_are_named() {
        for (line, expected) in [
            ("Kd 1 2", "`Kd` and three numbers, or one"),
            ("Ka one", "`Ka` and three numbers, or one"),
            ("Ns nan", "`Ns` and a number"),
        ] {
            let error = clean(Path::new("a.mtl"), &format!("newmtl a\n{line}\n"));
            let message = error.expect_err("it must be refused").to_string();
            assert_eq!(
                message,
                format!("a.mtl: line 2: is `{line}`; expected {expected}")
            );
        }
    }
}
