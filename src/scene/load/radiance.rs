//! Radiance pictures (.hdr, .pic): a header of text, then scanlines of shared-exponent texels.
//!
//! G. Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's "File Formats" (filefmts.pdf),
//! chapter "Picture files".

mod scanlines;

use super::chromaticities::{Primaries, REC709, XYZ};
use crate::error::InputError;
use glam::{DMat3, DVec2, DVec3};
use image::Rgb32FImage;
use scanlines::{Problem, decode_scanline, scale};
use std::path::Path;

/// Whether a file is one: its first line begins so, whatever program follows (`#?RADIANCE`,
/// `#?RGBE`, …).
pub(super) fn is_radiance(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// What the header says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) width: u32,
    pub(super) height: u32,
    layout: Layout,
    /// From the numbers in the file to linear BT.709; none where they are that.
    map: Option<DMat3>,
    /// Where the scanlines begin.
    texels: usize,
}

/// How scanlines lie in the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Layout {
    /// Whether scanlines are columns.
    columns: bool,
    /// Whether the first texel, or column, is the rightmost.
    from_right: bool,
    /// Whether the first texel, or row, is the lowest.
    from_below: bool,
}

/// Lines of the header that say something of colours.
#[derive(Debug, Default)]
struct Colors {
    xyz: bool,
    /// Product of all EXPOSURE and COLORCORR lines: what the radiances were multiplied by.
    factor: Option<DVec3>,
    primaries: Option<Primaries>,
}

/// Reads the header; what is odd in it goes to `warnings`.
pub(super) fn header(
    file: &Path,
    bytes: &[u8],
    warnings: &mut Vec<String>,
) -> Result<Header, InputError> {
    if !is_radiance(bytes) {
        return Err(InputError::file(
            file,
            "does not begin with `#?`",
            "a Radiance picture, whose first line is `#?RADIANCE` or the like",
        ));
    }
    let mut colors = Colors::default();
    let mut rest = bytes;
    loop {
        let line = next_line(file, &mut rest)?;
        if line.is_empty() {
            break;
        }
        read_line(file, &line, &mut colors, warnings)?;
    }
    let line = next_line(file, &mut rest)?;
    let (width, height, layout) = resolution(&line).ok_or_else(|| {
        let expected = "two sides such as `-Y 512 +X 1024`";
        InputError::new(file, "resolution", format!("is `{line}`"), expected)
    })?;
    Ok(Header {
        width,
        height,
        layout,
        map: colors.map(file, warnings)?,
        texels: bytes.len() - rest.len(),
    })
}

/// The next line of `rest`, without its end.
fn next_line(file: &Path, rest: &mut &[u8]) -> Result<String, InputError> {
    let end = rest.iter().position(|b| *b == b'\n');
    let end = end.ok_or_else(|| truncated(file))?;
    let line = String::from_utf8_lossy(&rest[..end]);
    let line = line.strip_suffix('\r').unwrap_or(&line).to_owned();
    *rest = &rest[end + 1..];
    Ok(line)
}

fn truncated(file: &Path) -> InputError {
    InputError::file(file, "is truncated", "the whole image")
}

/// Reads one line. Indented ones are the headers of pictures that this one was made of.
fn read_line(
    file: &Path,
    line: &str,
    colors: &mut Colors,
    warnings: &mut Vec<String>,
) -> Result<(), InputError> {
    let Some((key, value)) = line.split_once('=') else {
        return Ok(());
    };
    let value = value.trim();
    let positive = |count: usize, expected: &str| {
        let found = numbers(value).filter(|n| n.len() == count && n.iter().all(|n| *n > 0.0));
        found.ok_or_else(|| InputError::new(file, key, format!("is `{value}`"), expected))
    };
    match key {
        "FORMAT" => {
            colors.xyz = match value {
                "32-bit_rle_rgbe" => false,
                "32-bit_rle_xyze" => true,
                _ => {
                    let expected = "`32-bit_rle_rgbe` or `32-bit_rle_xyze`";
                    return Err(InputError::new(
                        file,
                        key,
                        format!("is `{value}`"),
                        expected,
                    ));
                }
            };
        }
        "EXPOSURE" => {
            let found = positive(1, "a number above 0")?;
            colors.multiply(DVec3::splat(found[0]));
        }
        "COLORCORR" => {
            let found = positive(3, "three numbers above 0")?;
            colors.multiply(DVec3::new(found[0], found[1], found[2]));
        }
        "PRIMARIES" => {
            let found = numbers(value).filter(|n| n.len() == 8);
            let found = found.ok_or_else(|| {
                let expected = "eight numbers: x and y of red, green, blue and white";
                InputError::new(file, key, format!("is `{value}`"), expected)
            })?;
            let point = |i: usize| DVec2::new(found[2 * i], found[2 * i + 1]);
            // Some programs write zeros for what they do not know.
            let known = found.iter().any(|n| *n != 0.0);
            colors.primaries = known.then(|| Primaries {
                red: point(0),
                green: point(1),
                blue: point(2),
                white: point(3),
            });
        }
        "GAMMA" if numbers(value).is_some_and(|n| n != [1.0]) => {
            let name = file.display();
            warnings.push(format!(
                "{name}: GAMMA={value} is ignored: Radiance pictures are linear"
            ));
        }
        _ => {}
    }
    Ok(())
}

/// The finite numbers of a line.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |word: &str| word.parse().ok().filter(|n: &f64| n.is_finite());
    text.split_ascii_whitespace().map(number).collect()
}

impl Colors {
    fn multiply(&mut self, factor: DVec3) {
        self.factor = Some(self.factor.unwrap_or(DVec3::ONE) * factor);
    }

    fn map(&self, file: &Path, warnings: &mut Vec<String>) -> Result<Option<DMat3>, InputError> {
        let mut map = None;
        if self.xyz {
            map = XYZ.to_rec709();
        } else if let Some(primaries) = self.primaries.filter(|p| !is_usual(p)) {
            map = Some(primaries.to_rec709().ok_or_else(|| {
                let problem = "are no triangle with white inside";
                InputError::new(file, "PRIMARIES", problem, "those of a colour space")
            })?);
            warnings.push(format!(
                "{}: its PRIMARIES are converted to those of BT.709",
                file.display()
            ));
        }
        let Some(factor) = self.factor else {
            return Ok(map);
        };
        let inverse = DMat3::from_diagonal(DVec3::ONE / factor);
        if !(inverse.is_finite() && factor.is_finite()) {
            let problem = format!("multiply to {factor}");
            let expected = "factors whose product is a number";
            return Err(InputError::new(file, "EXPOSURE", problem, expected));
        }
        Ok(Some(map.unwrap_or(DMat3::IDENTITY) * inverse))
    }
}

/// Whether these are what a file without PRIMARIES has: BT.709's, or Radiance's own, whose
/// difference nothing regards.
fn is_usual(primaries: &Primaries) -> bool {
    let own = Primaries {
        green: DVec2::new(0.29, 0.60),
        white: DVec2::splat(1.0 / 3.0),
        ..REC709
    };
    primaries.are(&REC709) || primaries.are(&own)
}

/// Width, height and layout of `-Y 512 +X 1024` and its seven siblings: the first side counts
/// scanlines.
fn resolution(line: &str) -> Option<(u32, u32, Layout)> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let [slow, scanlines, fast, texels] = words[..] else {
        return None;
    };
    let (scanlines, texels) = (scanlines.parse().ok()?, texels.parse().ok()?);
    let columns = slow.ends_with('X');
    let (x, y, width, height) = if columns {
        (slow, fast, scanlines, texels)
    } else {
        (fast, slow, texels, scanlines)
    };
    let from_right = sign(x, 'X')?;
    let from_below = !sign(y, 'Y')?;
    let layout = Layout {
        columns,
        from_right,
        from_below,
    };
    Some((width, height, layout))
}

/// Whether an axis is written with a minus.
fn sign(word: &str, axis: char) -> Option<bool> {
    match word.strip_suffix(axis)? {
        "-" => Some(true),
        "+" => Some(false),
        _ => None,
    }
}

impl Layout {
    /// Column and row of texel `index` of scanline `scanline`.
    fn place(self, size: [usize; 2], scanline: usize, index: usize) -> [usize; 2] {
        let [x, y] = if self.columns {
            [scanline, index]
        } else {
            [index, scanline]
        };
        let mirrored =
            |at: usize, size: usize, mirror: bool| if mirror { size - 1 - at } else { at };
        [
            mirrored(x, size[0], self.from_right),
            mirrored(y, size[1], self.from_below),
        ]
    }
}

/// Decodes the texels; sides have been checked.
pub(super) fn texels(
    file: &Path,
    bytes: &[u8],
    header: &Header,
) -> Result<Rgb32FImage, InputError> {
    let size = [header.width as usize, header.height as usize];
    let (scanlines, length) = if header.layout.columns {
        (size[0], size[1])
    } else {
        (size[1], size[0])
    };
    let scales: [f32; 256] = std::array::from_fn(scale);
    let mut image = Rgb32FImage::new(header.width, header.height);
    let (out, _) = image.as_chunks_mut::<3>();
    let mut rest = &bytes[header.texels..];
    let mut scanline = vec![[0; 4]; length];
    for number in 0..scanlines {
        decode_scanline(&mut rest, &mut scanline).map_err(|problem| match problem {
            Problem::Truncated => truncated(file),
            Problem::RunTooLong(texels) => InputError::new(
                file,
                format!("scanline {number}"),
                format!("has {texels} texels"),
                format!("{length}"),
            ),
        })?;
        for (index, &[r, g, b, e]) in scanline.iter().enumerate() {
            let scale = scales[usize::from(e)];
            let texel = [r, g, b].map(|c| f32::from(c) * scale);
            let [x, y] = header.layout.place(size, number, index);
            out[y * size[0] + x] = match header.map {
                None => texel,
                Some(map) => (map * DVec3::from_array(texel.map(f64::from)))
                    .as_vec3()
                    .to_array(),
            };
        }
    }
    Ok(image)
}
