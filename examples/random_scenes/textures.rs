//! Images that the scenes share.

/// Pixels per row and column of the pictures.
const SIDE: u32 = 64;

/// Their names and contents: colours with holes, and a sky with a small sun.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![("holes.png", holes()), ("sky.hdr", sky())]
}

/// Checks of two colours, with round holes in alpha and half of it around them.
fn holes() -> Vec<u8> {
    let image = image::RgbaImage::from_fn(SIDE, SIDE, |x, y| {
        let check = (x / 8 + y / 8) % 2 == 0;
        let [r, g, b] = if check {
            [210, 190, 120]
        } else {
            [60, 110, 70]
        };
        let [dx, dy] = [x, y].map(|a| (a % 16) as f32 - 7.5);
        let distance = dx.hypot(dy);
        let alpha = if distance < 4.0 {
            0
        } else if distance < 6.0 {
            128
        } else {
            255
        };
        image::Rgba([r, g, b, alpha])
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("memory takes an image");
    bytes.into_inner()
}

/// A sky that darkens towards the horizon with a sun of one texel, as flat RGBE.
fn sky() -> Vec<u8> {
    let (width, height) = (32, 16);
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n".to_vec();
    for y in 0..height {
        for x in 0..width {
            let up = 1.0 - f64::from(y) / f64::from(height);
            let sky = [0.3 * up, 0.5 * up, 0.9 * up];
            let is_sun = (x, y) == (9, 4);
            bytes.extend(rgbe(if is_sun { [900.0, 800.0, 600.0] } else { sky }));
        }
    }
    bytes
}

/// Three mantissas of eight bits with a common exponent (Ward 1991).
fn rgbe(rgb: [f64; 3]) -> [u8; 4] {
    let largest = rgb.into_iter().fold(0.0, f64::max);
    let exponent = largest.log2().floor() as i32 + 1;
    let mantissa = |x: f64| (x * 2_f64.powi(8 - exponent)) as u8;
    let [r, g, b] = rgb.map(mantissa);
    [r, g, b, (exponent + 128) as u8]
}
