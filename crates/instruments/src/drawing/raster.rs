//! Drawings as PNG.

use super::svg::Svg;
use direkt::error::Error;
use resvg::{tiny_skia, usvg};

/// Pixels per unit of a drawing.
const SCALE: f32 = 2.0;

/// A PNG of `svg` in light colours; its letters are those of the Ubuntu Font Family, which is
/// compiled in.
///
/// # Errors
/// The drawing cannot be drawn, which is direkt's own fault or that of memory.
pub fn png(svg: &Svg) -> Result<Vec<u8>, Error> {
    let fail = |message: String| Error::write("plot as PNG", std::io::Error::other(message));
    let mut options = usvg::Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().next().map(|f| f.families[0].0.clone());
    if let Some(family) = family {
        fonts.set_sans_serif_family(family.clone());
        options.font_family = family;
    }
    let tree = usvg::Tree::from_str(&svg.light(), &options).map_err(|e| fail(e.to_string()))?;
    let side = |length: f64| (length as f32 * SCALE).ceil() as u32;
    let mut pixels = tiny_skia::Pixmap::new(side(svg.width), side(svg.height))
        .ok_or_else(|| fail("it is empty".to_owned()))?;
    let transform = tiny_skia::Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, transform, &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| fail(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::super::svg::Anchor;
    use super::*;

    /// Without a font, or without a glyph in it, a PNG has gaps or boxes, and nothing says so.
    #[test]
    fn letters_are_drawn() {
        let draw = |text: &str| {
            let mut svg = Svg::new(100.0, 40.0, "t");
            svg.text((5.0, 30.0), 20.0, Anchor::Start, "ink", text);
            let png = png(&svg).expect("it can be drawn");
            let image = image::load_from_memory(&png).expect("a PNG").into_luma8();
            assert_eq!(image.dimensions(), (200, 80));
            image.into_raw()
        };
        let (empty, missing) = (draw(""), draw("\u{e123}"));
        for letter in "relMSE·−×µ²≈≥∞/>()0123456789⁻³".chars() {
            let drawn = draw(&letter.to_string());
            let there = drawn != empty && drawn != missing;
            assert!(there, "`{letter}` is not in the font");
        }
    }
}
