//! OpenEXR files as environment maps: luminance, chroma, layers, parts, primaries.

use super::files::Folder;
use direkt::scene::{EnvironmentRadiance, Scene};
use exr::prelude::*;
use glam::DVec3;
use std::io::Cursor;

const CAMERA: &str = "[camera]\neye = [0, 0, 0]\ntarget = [0, 0, -1]\nup = [0, 1, 0]\nfov = 60\n";

const SIZE: (usize, usize) = (4, 2);

/// Channels of the same value everywhere.
fn channels(named: &[(&str, f32)]) -> AnyChannels<FlatSamples> {
    let channel = |&(name, value): &(&str, f32)| {
        AnyChannel::new(name, FlatSamples::F32(vec![value; SIZE.0 * SIZE.1]))
    };
    AnyChannels::sort(named.iter().map(channel).collect())
}

fn layer(
    name: Option<&str>,
    named: &[(&str, f32)],
) -> exr::prelude::Layer<AnyChannels<FlatSamples>> {
    let attributes = match name {
        Some(name) => LayerAttributes::named(name),
        None => LayerAttributes::default(),
    };
    exr::prelude::Layer::new(SIZE, attributes, Encoding::UNCOMPRESSED, channels(named))
}

fn encoded(
    layers: Vec<exr::prelude::Layer<AnyChannels<FlatSamples>>>,
    primaries: Option<[f32; 8]>,
) -> Vec<u8> {
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
    let point = |p: &[f32; 8], i: usize| Vec2(p[2 * i], p[2 * i + 1]);
    attributes.chromaticities = primaries.map(|p| exr::meta::attribute::Chromaticities {
        red: point(&p, 0),
        green: point(&p, 1),
        blue: point(&p, 2),
        white: point(&p, 3),
    });
    let image = Image::from_layers(attributes, layers);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .expect("an EXR can be written");
    bytes.into_inner()
}

fn one(named: &[(&str, f32)]) -> Vec<u8> {
    encoded(vec![layer(None, named)], None)
}

fn load(bytes: &[u8], further: &str) -> std::result::Result<Scene, String> {
    let folder = Folder::new();
    folder.write("map.exr", bytes);
    folder.write(
        "scene.toml",
        format!("{CAMERA}[environment]\nfile = \"map.exr\"\n{further}\n"),
    );
    folder.load("scene.toml")
}

/// The radiance that a map has everywhere, and what is said of it.
fn radiance(bytes: &[u8], further: &str) -> (DVec3, Vec<String>) {
    let scene = load(bytes, further).expect("a valid map");
    let environment = scene.environment.expect("an environment");
    let EnvironmentRadiance::Map(map) = environment.radiance else {
        panic!("a map");
    };
    assert!(map.texels.iter().all(|t| *t == map.texels[0]));
    (
        DVec3::from_array(map.texels[0].map(f64::from)),
        scene.warnings,
    )
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).abs().max_element() < 1e-5
}

#[test]
fn luminance_alone_is_grey() {
    let (found, said) = radiance(&one(&[("Y", 0.75)]), "");
    assert_eq!((found, said), (DVec3::splat(0.75), Vec::new()));
    let (found, _) = radiance(&one(&[("Y", 0.75), ("A", 0.5)]), "");
    assert_eq!(found, DVec3::splat(0.75));
}

/// Y, RY = (R − Y)/Y and BY = (B − Y)/Y with BT.709's weights.
#[test]
fn chroma_becomes_colour() {
    let color = DVec3::new(0.9, 0.3, 0.1);
    let y = DVec3::new(0.2126, 0.7152, 0.0722).dot(color);
    let named = [
        ("Y", y as f32),
        ("RY", ((color.x - y) / y) as f32),
        ("BY", ((color.z - y) / y) as f32),
    ];
    let (found, _) = radiance(&one(&named), "");
    // The weights of the standard have four digits.
    assert!((found - color).abs().max_element() < 2e-4, "{found}");
}

#[test]
fn names_of_channels_may_be_small() {
    let (found, _) = radiance(&one(&[("r", 1.0), ("g", 2.0), ("b", 3.0)]), "");
    assert_eq!(found, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn layers_are_found_and_named() {
    let combined = [
        ("ViewLayer.Combined.R", 1.0),
        ("ViewLayer.Combined.G", 2.0),
        ("ViewLayer.Combined.B", 3.0),
        ("ViewLayer.Combined.A", 1.0),
        ("ViewLayer.Depth.Z", 9.0),
    ];
    let (found, said) = radiance(&one(&combined), "");
    assert_eq!(found, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(said.len(), 1);
    assert!(
        said[0].ends_with("its layer `ViewLayer.Combined` is used"),
        "{said:?}"
    );
    let (found, said) = radiance(&one(&combined), "layer = \"ViewLayer.Combined\"");
    assert_eq!((found, said), (DVec3::new(1.0, 2.0, 3.0), Vec::new()));

    let two = [
        ("left.R", 1.0),
        ("left.G", 1.0),
        ("left.B", 1.0),
        ("right.R", 2.0),
        ("right.G", 2.0),
        ("right.B", 2.0),
    ];
    let message = load(&one(&two), "").expect_err("which is meant?");
    assert!(message.contains("several layers"), "{message}");
    assert!(message.contains("left, right"), "{message}");
    let (found, _) = radiance(&one(&two), "layer = \"right\"");
    assert_eq!(found, DVec3::splat(2.0));
    let message = load(&one(&two), "layer = \"middle\"").expect_err("no such layer");
    assert!(message.contains("`middle`"), "{message}");
    // Among further layers of colours the whole image is known by its name.
    let mut further = combined.to_vec();
    further.extend([
        ("ViewLayer.DiffCol.R", 5.0),
        ("ViewLayer.DiffCol.G", 5.0),
        ("ViewLayer.DiffCol.B", 5.0),
    ]);
    assert_eq!(radiance(&one(&further), "").0, DVec3::new(1.0, 2.0, 3.0));
    // Colours without a layer come before those of layers.
    let mut root = two.to_vec();
    root.extend([("R", 4.0), ("G", 4.0), ("B", 4.0)]);
    assert_eq!(radiance(&one(&root), ""), (DVec3::splat(4.0), Vec::new()));
}

#[test]
fn parts_have_names() {
    let rgb = |value: f32| [("R", value), ("G", value), ("B", value)];
    let bytes = encoded(
        vec![
            layer(Some("depth"), &[("Z", 9.0)]),
            layer(Some("beauty"), &rgb(1.0)),
            layer(Some("glow"), &rgb(2.0)),
        ],
        None,
    );
    assert_eq!(radiance(&bytes, "").0, DVec3::ONE);
    assert_eq!(radiance(&bytes, "layer = \"glow\"").0, DVec3::splat(2.0));
}

/// Chromaticities of XYZ make a file of CIE XYZ; grey is grey under any.
#[test]
fn chromaticities_are_converted_with_a_message() {
    let xyz = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0];
    let white = [("R", 0.950_456), ("G", 1.0), ("B", 1.089_058)];
    let (found, said) = radiance(&encoded(vec![layer(None, &white)], Some(xyz)), "");
    assert!((found - DVec3::ONE).abs().max_element() < 2e-4, "{found}");
    assert!(
        said.len() == 1 && said[0].contains("chromaticities"),
        "{said:?}"
    );
    let bytes = encoded(vec![layer(None, &[("Y", 0.5)])], Some(xyz));
    assert_eq!(radiance(&bytes, ""), (DVec3::splat(0.5), Vec::new()));
    let rec709 = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329];
    let rgb = [("R", 0.2), ("G", 0.4), ("B", 0.8)];
    let (found, said) = radiance(&encoded(vec![layer(None, &rgb)], Some(rec709)), "");
    assert!(close(found, DVec3::new(0.2, 0.4, 0.8)) && said.is_empty());
}

#[test]
fn what_is_no_colour_is_refused_by_name() {
    let message = load(&one(&[("Z", 1.0), ("N.X", 1.0)]), "").expect_err("no colours");
    assert!(message.contains("its channels are N.X, Z"), "{message}");
    // Half as many samples of chroma as texels along each side.
    let mut subsampled = one(&[("Y", 0.5), ("RY", 0.0), ("BY", 0.0)]);
    for name in [b"RY\0", b"BY\0"] {
        let at = subsampled.windows(3).position(|w| w == name);
        let sampling = at.expect("a channel") + 3 + 8;
        subsampled[sampling..sampling + 8].copy_from_slice(&[2, 0, 0, 0, 2, 0, 0, 0]);
    }
    let message = load(&subsampled, "").expect_err("subsampled chroma");
    assert!(message.contains("subsampled chroma"), "{message}");
    let folder = Folder::new();
    folder.write("map.hdr", b"#?RGBE\n\n-Y 1 +X 1\nabcd");
    folder.write(
        "scene.toml",
        "[environment]\nfile = \"map.hdr\"\nlayer = \"a\"\n",
    );
    let message = folder.load("scene.toml").expect_err("no layers");
    assert!(message.contains("has no layers"), "{message}");
}
