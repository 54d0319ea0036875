//! Radiance pictures as environment maps: every layout, encoding and header line that says
//! something of colours.

use super::files::Folder;
use direkt::scene::{EnvironmentRadiance, Scene};
use glam::DVec3;

const WIDTH: usize = 9;
const HEIGHT: usize = 3;

/// Texel of column `x` and row `y`, mantissas and exponent; no two are the same.
fn texel(x: usize, y: usize) -> [u8; 4] {
    let n = (10 + 7 * x + 70 * y) as u8;
    [n, n / 2, 255 - n, 129 + (x % 3) as u8]
}

fn value([r, g, b, e]: [u8; 4]) -> DVec3 {
    let scale = (f64::from(e) - 136.0).exp2();
    DVec3::new(r.into(), g.into(), b.into()) * scale
}

/// A file of this header and these texels, one after another.
fn file(header: &str, resolution: &str, texels: impl IntoIterator<Item = [u8; 4]>) -> Vec<u8> {
    let mut bytes = format!("{header}\n\n{resolution}\n").into_bytes();
    bytes.extend(texels.into_iter().flatten());
    bytes
}

const HEAD: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";

/// The texels row by row from the upper left.
fn rows() -> Vec<[u8; 4]> {
    let all = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| texel(x, y)));
    all.collect()
}

fn load(bytes: &[u8]) -> Result<Scene, String> {
    let folder = Folder::new();
    folder.write("map.hdr", bytes);
    folder.write("scene.toml", "[environment]\nfile = \"map.hdr\"\n");
    folder.load("scene.toml")
}

fn radiances(scene: &Scene) -> Vec<DVec3> {
    let environment = scene.environment.as_ref().expect("an environment");
    let EnvironmentRadiance::Map(map) = &environment.radiance else {
        panic!("a map");
    };
    assert_eq!((map.width, map.height), (WIDTH as u32, HEIGHT as u32));
    let texels = map.texels.iter();
    texels
        .map(|t| DVec3::from_array(t.map(f64::from)))
        .collect()
}

/// Checks that `bytes` are an image whose texels are `expected` of those of the plain one.
fn check(what: &str, bytes: &[u8], expected: impl Fn(DVec3) -> DVec3) {
    let scene = load(bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
    for (found, texel) in radiances(&scene).into_iter().zip(rows()) {
        let expected = expected(value(texel));
        let off = (found - expected).abs().max_element();
        assert!(
            off <= 1e-6 * expected.length(),
            "{what}: {found} for {expected}"
        );
    }
}

#[test]
fn all_eight_layouts_are_the_same_image() {
    let (w, h) = (WIDTH, HEIGHT);
    for y_down in [true, false] {
        for x_right in [true, false] {
            let y_axis = format!("{}Y {h}", if y_down { '-' } else { '+' });
            let x_axis = format!("{}X {w}", if x_right { '+' } else { '-' });
            let at = |x: usize, y: usize| {
                texel(
                    if x_right { x } else { w - 1 - x },
                    if y_down { y } else { h - 1 - y },
                )
            };
            let by_rows = (0..h).flat_map(|y| (0..w).map(move |x| at(x, y)));
            let bytes = file(HEAD, &format!("{y_axis} {x_axis}"), by_rows);
            check(&format!("{y_axis} {x_axis}"), &bytes, |v| v);
            let by_columns = (0..w).flat_map(|x| (0..h).map(move |y| at(x, y)));
            let bytes = file(HEAD, &format!("{x_axis} {y_axis}"), by_columns);
            check(&format!("{x_axis} {y_axis}"), &bytes, |v| v);
        }
    }
}

#[test]
fn first_lines_of_any_program_are_known() {
    for first in ["#?RADIANCE", "#?RGBE", "#?AUTOPANO", "#?RADIANCE\r"] {
        let header = format!("{first}\n# a comment\nFORMAT=32-bit_rle_rgbe\nVIEW= -vp 0 0 0");
        check(first, &file(&header, "-Y 3 +X 9", rows()), |v| v);
    }
    // A FORMAT left out is RGBE.
    check("no FORMAT", &file("#?RGBE", "-Y 3 +X 9", rows()), |v| v);
}

/// EXPOSURE and COLORCORR are what radiances were multiplied by, all lines together; indented lines
/// are other pictures'.
#[test]
fn exposures_are_divided_out() {
    let lines = |lines: &str| file(&format!("{HEAD}\n{lines}"), "-Y 3 +X 9", rows());
    check("once", &lines("EXPOSURE=4"), |v| v / 4.0);
    check("twice", &lines("EXPOSURE= 4\nEXPOSURE=0.5"), |v| v / 2.0);
    check("another's", &lines("\tEXPOSURE=4"), |v| v);
    let colors = DVec3::new(2.0, 1.0, 0.5);
    check("colours", &lines("EXPOSURE=2\nCOLORCORR=2 1 0.5"), |v| {
        v / (2.0 * colors)
    });
}

/// Runs by component, and the older ones of whole texels.
#[test]
fn runs_are_unpacked() {
    let mut bytes = file(HEAD, "-Y 3 +X 9", []);
    for y in 0..HEIGHT {
        bytes.extend([2, 2, 0, WIDTH as u8]);
        for component in 0..4 {
            let values: Vec<u8> = (0..WIDTH).map(|x| texel(x, y)[component]).collect();
            // Two as they are, a run of one, the rest as they are.
            bytes.push(2);
            bytes.extend(&values[..2]);
            bytes.extend([129, values[2], 6]);
            bytes.extend(&values[3..]);
        }
    }
    check("by component", &bytes, |v| v);
    let one = [100, 50, 25, 130];
    let rows = [[one, [1, 1, 1, 8]], [one, [1, 1, 1, 8]]].concat();
    let third = [one, [1, 1, 1, 3], one, [1, 1, 1, 4]].concat();
    let mut bytes = file(HEAD, "-Y 3 +X 9", rows);
    bytes.extend(third);
    let scene = load(&bytes).expect("older runs");
    assert!(radiances(&scene).iter().all(|r| *r == value(one)));
    assert_eq!(radiances(&scene).len(), WIDTH * HEIGHT);
    // 1 + 3 + 256 texels.
    let long = file(HEAD, "-Y 1 +X 260", [one, [1, 1, 1, 3], [1, 1, 1, 1]]);
    let scene = load(&long).expect("a run of two words");
    assert!(matches!(
        &scene.environment.expect("an environment").radiance,
        EnvironmentRadiance::Map(map) if map.texels.iter().all(|t| t[0] > 0.0)
    ));
}

/// XYZ of BT.709's white and red (IEC 61966-2-1).
#[test]
fn xyz_becomes_linear_rgb() {
    let word = |v: f64| (v * 128.0).round() as u8;
    let white = [0.9505, 1.0, 1.089].map(word);
    let red = [0.4124, 0.2126, 0.0193].map(word);
    let texels = [white, red].map(|[x, y, z]| [x, y, z, 129]);
    let texels = texels.into_iter().cycle().take(WIDTH * HEIGHT);
    let bytes = file("#?RADIANCE\nFORMAT=32-bit_rle_xyze", "-Y 3 +X 9", texels);
    let found = radiances(&load(&bytes).expect("XYZE"));
    // Mantissas are rounded to 1/128, which the map's largest row sum, 5.3, magnifies.
    for (found, expected) in found.iter().zip([DVec3::ONE, DVec3::X]) {
        let off = (*found - expected).abs().max_element();
        assert!(off < 5.3 * 0.5 / 128.0, "{found} for {expected}");
    }
}

#[test]
fn primaries_are_converted_with_a_message() {
    let lines = |lines: &str| file(&format!("{HEAD}\n{lines}"), "-Y 3 +X 9", rows());
    // White stays white under other primaries; green of P3 is beyond BT.709's.
    let grey = file(
        &format!("{HEAD}\nPRIMARIES= .68 .32 .265 .69 .15 .06 .3127 .329"),
        "-Y 3 +X 9",
        [[128, 128, 128, 129]; WIDTH * HEIGHT],
    );
    let scene = load(&grey).expect("P3");
    assert!(
        radiances(&scene)
            .iter()
            .all(|r| (*r - DVec3::ONE).length() < 1e-6)
    );
    assert_eq!(
        scene
            .warnings
            .iter()
            .filter(|w| w.contains("PRIMARIES"))
            .count(),
        1
    );
    for usual in [
        "PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329",
        "PRIMARIES=0 0 0 0 0 0 0 0",
        "PRIMARIES=0.6400 0.3300 0.2900 0.6000 0.1500 0.0600 0.3333 0.3333",
    ] {
        check(usual, &lines(usual), |v| v);
        let scene = load(&lines(usual)).expect("valid");
        assert!(scene.warnings.iter().all(|w| !w.contains("PRIMARIES")));
    }
}

/// The content tells the format, whatever the name says.
#[test]
fn names_may_lie() {
    let folder = Folder::new();
    folder.write("map.exr", file(HEAD, "-Y 3 +X 9", rows()));
    folder.write("scene.toml", "[environment]\nfile = \"map.exr\"\n");
    let scene = folder.load("scene.toml").expect("a Radiance picture");
    assert_eq!(radiances(&scene).len(), WIDTH * HEIGHT);
    folder.write("map.exr", super::textures::png(&[[1, 2, 3]]));
    let message = folder.load("scene.toml").expect_err("a PNG");
    assert!(
        message.contains("map.exr: is of the format Png"),
        "{message}"
    );
}

#[test]
fn odd_headers_are_refused_by_name() {
    for (line, resolution, expected) in [
        ("EXPOSURE=0", "-Y 3 +X 9", "EXPOSURE: is `0`"),
        ("EXPOSURE=nan", "-Y 3 +X 9", "EXPOSURE: is `nan`"),
        (
            "EXPOSURE=1e308\nEXPOSURE=1e308",
            "-Y 3 +X 9",
            "EXPOSURE: multiply to [inf, inf, inf]",
        ),
        ("COLORCORR=1 2", "-Y 3 +X 9", "COLORCORR: is `1 2`"),
        ("PRIMARIES=1 2 3", "-Y 3 +X 9", "PRIMARIES: is `1 2 3`"),
        (
            "FORMAT=32-bit_rle_lab",
            "-Y 3 +X 9",
            "FORMAT: is `32-bit_rle_lab`",
        ),
        ("A=1", "-Y 3 +Y 9", "resolution: is `-Y 3 +Y 9`"),
        ("A=1", "-Y 3 +X -9", "resolution: is `-Y 3 +X -9`"),
        ("A=1", "-Y 3", "resolution: is `-Y 3`"),
        ("A=1", "-Y 3 +X 10", "is truncated"),
    ] {
        let bytes = file(&format!("{HEAD}\n{line}"), resolution, rows());
        let message = load(&bytes).expect_err(line);
        assert!(message.contains(expected), "{message}");
    }
}
