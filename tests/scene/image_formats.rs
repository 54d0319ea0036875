//! Images of every format as textures.

use super::files::{Folder, load_gltf, triangle_gltf, with};
use super::textures::with_texture;
use direkt::scene::{Bsdf, Scene, Texture};
use glam::DVec3;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb};
use serde_json::json;
use std::io::Cursor;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = image.write_to(&mut Cursor::new(&mut bytes), format);
    written.expect("an image can be written");
    bytes
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let byte = |i: usize| u8::from_str_radix(&hex[i..i + 2], 16).expect("hexadecimal");
    (0..hex.len()).step_by(2).map(byte).collect()
}

/// A scene with a material that is coloured by the image `name`.
fn load(name: &str, bytes: &[u8]) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write(name, bytes);
    let scene = format!(
        "[environment]\nradiance = 1\n[[shapes]]\ntype = \"rectangle\"\nmaterial = \"m\"\ncorner = [0, 0, 0]\n\
         u = [1, 0, 0]\nv = [0, 1, 0]\n[materials.m]\ntype = \"lambert\"\nreflectance = 1\n\
         textures.color = {{ file = \"{name}\" }}\n"
    );
    folder.write("scene.toml", scene);
    folder.load("scene.toml")
}

fn texture(name: &str, bytes: &[u8]) -> Texture {
    let scene = load(name, bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
    scene.textures[0].clone()
}

/// Linear value of 8-bit sRGB (IEC 61966-2-1).
fn linear(level: u8) -> f64 {
    let encoded = f64::from(level) / 255.0;
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Checks texel `x` of row 0; f16 rounds by 2⁻¹¹.
fn check(name: &str, texture: &Texture, x: u32, [r, g, b]: [u8; 3]) {
    let found = texture.texel(x, 0).truncate();
    let expected = DVec3::new(linear(r), linear(g), linear(b));
    assert!(
        (found - expected).abs().max_element() < 5e-4,
        "{name}: {found}"
    );
}

#[test]
fn formats_are_decoded() {
    let colors = [[200, 100, 50], [10, 20, 30]];
    let row = ImageBuffer::from_fn(2, 1, |x, _| Rgb(colors[x as usize]));
    let image = DynamicImage::ImageRgb8(row);
    for (name, format) in [
        ("x.png", ImageFormat::Png),
        ("x.bmp", ImageFormat::Bmp),
        ("x.tga", ImageFormat::Tga),
        ("x.TGA", ImageFormat::Tga),
        ("x.tiff", ImageFormat::Tiff),
        ("x.webp", ImageFormat::WebP),
        // The content counts.
        ("x.jpg", ImageFormat::Png),
        ("x.exr", ImageFormat::WebP),
    ] {
        let found = texture(name, &encoded(&image, format));
        assert_eq!((found.width, found.height), (2, 1));
        check(name, &found, 0, colors[0]);
        check(name, &found, 1, colors[1]);
    }
}

#[test]
fn kinds_of_png_are_decoded() {
    let one_bit = "89504e470d0a1a0a0000000d4948445200000002000000010100000000dc5942270000000a4944415478da637000000042004184\
        bf8e620000000049454e44ae426082";
    let found = texture("bit.png", &bytes_of(one_bit));
    check("1 bit", &found, 0, [0; 3]);
    check("1 bit", &found, 1, [255; 3]);
    let palette = "89504e470d0a1a0a0000000d4948445200000002000000010803000000c3fc8fb800000006504c54450a141ec8643277a0b39c000000\
        0274524e53ff80080fb36a0000000b4944415478da63606400000005000242c2449f0000000049454e44ae426082";
    let found = texture("palette.png", &bytes_of(palette));
    check("palette", &found, 0, [200, 100, 50]);
    check("palette", &found, 1, [10, 20, 30]);
    assert!((found.texel(0, 0).w - 128.0 / 255.0).abs() < 5e-4);
    let row = ImageBuffer::from_fn(2, 1, |x, _| LumaA([40 + 100 * x as u8, 255]));
    let grey = encoded(&DynamicImage::ImageLumaA8(row), ImageFormat::Png);
    check("grey and alpha", &texture("grey.png", &grey), 1, [140; 3]);
    let row = ImageBuffer::from_fn(2, 1, |x, _| Rgb([257 * 200, 257 * 100, 257 * x as u16]));
    let words = encoded(&DynamicImage::ImageRgb16(row), ImageFormat::Png);
    check("16 bits", &texture("words.png", &words), 1, [200, 100, 1]);
}

/// Constant images, so that they are factors: a grey one, and one of cyan, magenta, yellow and
/// black as Adobe writes it, inverted: (255, 128, 64) without black.
#[test]
fn kinds_of_jpeg_are_decoded() {
    let reflectance = |bytes: &[u8]| {
        let scene = load("x.jpg", bytes).expect("a valid image");
        let Bsdf::Lambert { reflectance } = scene.materials[0].bsdf else {
            panic!("a lambert");
        };
        reflectance
    };
    let grey = "ffd8ffdb00430008080808080808080808080808080808080808080808080808080808080808080808080808080808080808\
        080808080808080808080808080808080808080808ffc0000b080008000801011100ffc40014000100000000000000000000\
        000000000000ffc40014100100000000000000000000000000000000ffda0008010100003f003fffd9";
    let found = reflectance(&bytes_of(grey));
    assert!(
        (found - DVec3::splat(linear(128))).length() < 2e-3,
        "{found}"
    );
    let cmyk = "ffd8ffee000e41646f626500640000000000ffdb004300080808080808080808080808080808080808080808080808080808\
        08080808080808080808080808080808080808080808080808080808080808080808080808ffc00014080008000804011100\
        021100031100041100ffc4001c0000000009000000000000000000000000000102030405060708ffc4001410010000000000\
        0000000000000000000000ffda000e040100020003000400003f007fe03bf3ff007fffd9";
    let found = reflectance(&bytes_of(cmyk));
    let expected = DVec3::new(linear(255), linear(128), linear(64));
    assert!((found - expected).abs().max_element() < 1e-2, "{found}");
}

/// Grey stands for equal red, green and blue: roughness and metallic of 64/255.
#[test]
fn grey_images_are_all_three_channels() {
    let material = |map: &str| json!([{ map: { "index": 0 } }]);
    let grey = |levels: [u8; 2]| {
        let row = ImageBuffer::from_fn(2, 1, |x, _| Luma([levels[x as usize]]));
        encoded(&DynamicImage::ImageLuma8(row), ImageFormat::Png)
    };
    let pbr = json!([{ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 0 } } }]);
    let json = with(triangle_gltf(), "/materials", pbr);
    let scene = load_gltf(&with_texture(json.clone(), &grey([64, 64]))).expect("grey");
    let Bsdf::MetallicRoughness {
        metallic,
        roughness,
        ..
    } = scene.materials[0].bsdf
    else {
        panic!("glTF's model");
    };
    assert!((metallic - 64.0 / 255.0).abs() < 1e-9 && (roughness - 64.0 / 255.0).abs() < 1e-9);
    let scene = load_gltf(&with_texture(json, &grey([64, 65]))).expect("grey");
    let texel = scene.textures[0].texel(1, 0);
    assert_eq!((texel.y, texel.z), (65.0 / 255.0, 65.0 / 255.0));
    // A normal map of one channel is probably a height map.
    let json = with(triangle_gltf(), "/materials", material("normalTexture"));
    let scene = load_gltf(&with_texture(json, &grey([64, 65]))).expect("grey");
    assert!(scene.warnings.iter().any(|w| w.contains("height map")));
}

#[test]
fn damaged_images_are_named() {
    let row = ImageBuffer::from_fn(64, 64, |x, y| Rgb([x as u8, y as u8, (x * y) as u8]));
    let image = DynamicImage::ImageRgb8(row);
    for (name, format) in [
        ("cut.png", ImageFormat::Png),
        ("cut.bmp", ImageFormat::Bmp),
        ("cut.tga", ImageFormat::Tga),
        ("cut.tiff", ImageFormat::Tiff),
        ("cut.webp", ImageFormat::WebP),
    ] {
        let bytes = encoded(&image, format);
        let message = load(name, &bytes[..bytes.len() / 2]).expect_err(name);
        assert!(
            message.starts_with(&format!("DIR/{name}: is ")),
            "{message}"
        );
    }
    let mut large = encoded(&image, ImageFormat::Bmp);
    large[18..26].copy_from_slice(&[0x40, 0x9c, 0, 0, 0x40, 0x9c, 0, 0]);
    let message = load("large.bmp", &large).expect_err("40,000 texels per side");
    assert!(
        message.contains("is an image of 40000 x 40000 texels"),
        "{message}"
    );
    let message = load("x.gif", b"GIF89a").expect_err("a GIF");
    assert!(message.contains("is of the format Gif"), "{message}");
}
