//! Drawings as SVG: lines, shapes and text whose colours are classes.

use super::text::{SUPERSCRIPTS, escape};
use std::fmt::Write;

/// Colours of one theme.
struct Theme {
    paper: &'static str,
    ink: &'static str,
    faint: &'static str,
    grid: &'static str,
    series: [&'static str; SERIES],
}

/// Different colours of curves.
pub const SERIES: usize = 12;

const LIGHT: Theme = Theme {
    paper: "#ffffff",
    ink: "#1b1f27",
    faint: "#5a6270",
    grid: "#e3e6ec",
    series: [
        "#1764c8", "#d4570a", "#178243", "#b02a8f", "#c8202b", "#0b8490", "#6a48d0", "#8a5a22",
        "#59616e", "#7d8a00", "#1b2f6b", "#e0679b",
    ],
};

const DARK: Theme = Theme {
    paper: "#171b22",
    ink: "#eef1f6",
    faint: "#a3adbb",
    grid: "#2c323d",
    series: [
        "#6cb0ff", "#ff9d52", "#56d08b", "#f283cd", "#ff7d7d", "#4dd5de", "#ad98ff", "#d8a873",
        "#b1bac6", "#c9d64f", "#d0d8ff", "#ffb3cf",
    ],
};

/// CSS of the classes that drawings use.
fn css(theme: &Theme) -> String {
    let Theme {
        paper,
        ink,
        faint,
        grid,
        series,
    } = theme;
    let mut css = format!(
        ".paper{{fill:{paper}}}.ink{{fill:{ink}}}.faint{{fill:{faint}}}.grid{{stroke:{grid};stroke-width:1}}\
         .minor{{stroke:{grid};stroke-width:0.5}}.axis{{stroke:{faint};stroke-width:1.2}}.halo{{stroke:{paper}}}"
    );
    for (i, colour) in series.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(css, ".s{i}{{stroke:{colour}}}.f{i}{{fill:{colour}}}");
    }
    css
}

/// The CSS of both themes, as the reader's system is set.
pub fn adaptive_css() -> String {
    format!(
        "{}@media (prefers-color-scheme:dark){{{}}}",
        css(&LIGHT),
        css(&DARK)
    )
}

/// Pixels that `text` takes at most in usual fonts, to leave room for it.
pub fn room_for(text: &str, size: f64) -> f64 {
    0.55 * size * text.chars().count() as f64
}

/// A drawing.
#[derive(Debug, Clone)]
pub struct Svg {
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
    title: String,
    body: String,
}

/// Where text is held.
#[derive(Debug, Clone, Copy)]
pub enum Anchor {
    /// At its beginning.
    Start,
    /// In its middle.
    Middle,
    /// At its end.
    End,
}

impl Svg {
    /// An empty drawing; `title` says what it shows to those who do not see it.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        Self {
            width,
            height,
            title: title.to_owned(),
            body: String::new(),
        }
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }

    /// A line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str, extra: &str) {
        let ((x1, y1), (x2, y2)) = (from, to);
        self.push(format_args!(
            r#"<line class="{class}" x1="{x1:.2}" y1="{y1:.2}" x2="{x2:.2}" y2="{y2:.2}" {extra}/>"#
        ));
    }

    /// A polyline.
    pub fn polyline(&mut self, points: &[(f64, f64)], class: &str, extra: &str) {
        let points: Vec<_> = points
            .iter()
            .map(|(x, y)| format!("{x:.2},{y:.2}"))
            .collect();
        self.push(format_args!(
            r#"<polyline class="{class}" fill="none" points="{}" {extra}/>"#,
            points.join(" ")
        ));
    }

    /// A rectangle from its upper left corner.
    pub fn rectangle(&mut self, at: (f64, f64), size: (f64, f64), class: &str, extra: &str) {
        let ((x, y), (w, h)) = (at, size);
        self.push(format_args!(
            r#"<rect class="{class}" x="{x:.2}" y="{y:.2}" width="{w:.2}" height="{h:.2}" {extra}/>"#
        ));
    }

    /// A mark at a point: `shape` 0 is a filled disk, 1 an open one, 2 a filled square, 3 an open
    /// one, 4 a cross.
    pub fn mark(&mut self, at: (f64, f64), shape: usize, series: usize) {
        let (x, y) = at;
        if shape == 4 {
            let (class, arm) = (format!("s{series}"), 5.5);
            self.line((x - arm, y), (x + arm, y), &class, r#"stroke-width="1.8""#);
            self.line((x, y - arm), (x, y + arm), &class, r#"stroke-width="1.8""#);
            return;
        }
        let class = if shape % 2 == 1 {
            format!("s{series} paper")
        } else {
            format!("s{series} f{series}")
        };
        if shape < 2 {
            self.push(format_args!(
                r#"<circle class="{class}" cx="{x:.2}" cy="{y:.2}" r="4.2" stroke-width="1.8"/>"#
            ));
        } else {
            let at = (x - 3.8, y - 3.8);
            self.rectangle(at, (7.6, 7.6), &class, r#"stroke-width="1.8""#);
        }
    }

    /// Text on a base line.
    pub fn text(&mut self, at: (f64, f64), size: f64, anchor: Anchor, class: &str, text: &str) {
        self.rich_text(at, size, anchor, class, &raised(&escape(text), size));
    }

    fn rich_text(&mut self, at: (f64, f64), size: f64, anchor: Anchor, class: &str, markup: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = at;
        self.push(format_args!(
            r#"<text class="{class}" x="{x:.2}" y="{y:.2}" font-size="{size}" text-anchor="{anchor}">{markup}</text>"#
        ));
    }

    /// Text along a vertical axis, read from below.
    pub fn vertical_text(&mut self, at: (f64, f64), size: f64, text: &str) {
        let (x, y) = at;
        self.push(format_args!(
            r#"<text class="ink" transform="translate({x:.2} {y:.2}) rotate(-90)" font-size="{size}" text-anchor="middle">{}</text>"#,
            escape(text)
        ));
    }

    fn element(&self, attributes: &str, style: &str) -> String {
        let (w, h) = (self.width, self.height);
        let title = escape(&self.title);
        format!(
            "<svg {attributes}viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{title}\" \
             font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\">\n<title>{title}</title>\n{style}{}</svg>\n",
            self.body
        )
    }

    /// As part of a page, which holds [`adaptive_css`].
    pub fn inline(&self) -> String {
        self.element("", "")
    }

    /// As a file that follows the reader's theme.
    pub fn file(&self) -> String {
        self.standalone(&adaptive_css())
    }

    /// As a file with light colours.
    pub fn light(&self) -> String {
        self.standalone(&css(&LIGHT))
    }

    fn standalone(&self, css: &str) -> String {
        let (w, h) = (self.width, self.height);
        let attributes =
            format!("xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" ");
        let paper =
            format!("<style>{css}</style>\n<rect class=\"paper\" width=\"{w}\" height=\"{h}\"/>\n");
        self.element(&attributes, &paper)
    }
}

/// `markup` with superscript characters, which few fonts have all of, as small characters above the
/// line.
fn raised(markup: &str, size: f64) -> String {
    let mut out = String::new();
    let mut up = false;
    for c in markup.chars() {
        let plain = SUPERSCRIPTS.iter().find(|s| s.1 == c).map(|s| s.0);
        if plain.is_some() != up {
            let dy = if up { 0.42 } else { -0.42 } * size;
            if !out.is_empty() && out.contains("<tspan") {
                out.push_str("</tspan>");
            }
            let size = if up { size } else { 0.74 * size };
            // Writing to a string cannot fail.
            let _ = write!(out, r#"<tspan dy="{dy:.1}" font-size="{size:.1}">"#);
            up = !up;
        }
        out.push(plain.unwrap_or(c));
    }
    if out.contains("<tspan") {
        out.push_str("</tspan>");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superscripts_are_raised() {
        let expected = r#"2·10<tspan dy="-4.2" font-size="7.4">−3</tspan><tspan dy="4.2" font-size="10.0"> s</tspan>"#;
        assert_eq!(raised("2·10⁻³ s", 10.0), expected);
        assert_eq!(raised("a", 10.0), "a");
    }

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new(10.0, 10.0, "a <b> \"c\"");
        svg.text((0.0, 0.0), 9.0, Anchor::Start, "ink", "<script>&");
        let text = svg.inline();
        assert!(text.contains("&lt;script&gt;&amp;") && !text.contains("<script>"));
        assert!(text.contains("a &lt;b&gt; &quot;c&quot;"));
    }
}
