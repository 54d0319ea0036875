//! A short run of the fuzzer: the example `fuzz` does the same for as long as one likes.

#[path = "../../examples/fuzz/harness/mod.rs"]
pub(super) mod harness;

use super::files::load_toml;
use direkt::scene::Geometry;
use direkt::scene::validate::validate;
use glam::DVec3;
use harness::{Inputs, Reader, Workplace, execute, guarded, kind, sound};

/// Inputs per reader: together a few seconds.
const INPUTS: usize = 2000;

/// Whatever has become of a valid file, it is a scene that is fit for the GPU, or it is refused in
/// one line.
fn survives(reader: Reader) {
    let place = Workplace::new(reader).expect("a temporary folder can be made");
    for (number, seed) in reader.seeds().iter().enumerate() {
        let read = execute(&place, seed);
        assert_eq!(read, Ok(None), "{reader:?}: seed {number} is valid");
        assert!(
            seed.len() < 4096,
            "{reader:?}: seed {number} is compressed, where it can be: {} bytes",
            seed.len()
        );
    }
    let mut inputs = Inputs::new(reader, 1);
    for number in 0..INPUTS {
        let input = inputs.next();
        match execute(&place, &input) {
            Ok(None) => {}
            Ok(Some(message)) => inputs.refused(&input, &message),
            Err(problem) => panic!(
                "{reader:?}, input {number}: {problem}\n{}",
                input.escape_ascii()
            ),
        }
    }
    // Inputs that all fail at the same check would test nothing.
    assert!(inputs.kinds() >= 10, "{reader:?}: {}", inputs.kinds());
}

#[test]
fn damaged_scenes_are_survived() {
    for reader in [Reader::Toml, Reader::Numbers, Reader::Validate] {
        survives(reader);
    }
}

#[test]
fn damaged_meshes_are_survived() {
    for reader in [Reader::Gltf, Reader::Glb, Reader::Ply, Reader::Obj] {
        survives(reader);
    }
}

#[test]
fn damaged_maps_are_survived() {
    for reader in [Reader::Hdr, Reader::Exr] {
        survives(reader);
    }
}

#[test]
fn a_panic_is_a_failure() {
    let found = guarded::<()>(|| panic!("index {} is out of range", 7));
    assert_eq!(found, Err("panicked: index 7 is out of range".to_owned()));
    assert_eq!(guarded(|| Ok(1)), Ok(1));
}

/// What `validate` refuses would have reached the GPU as an infinity, and is found where it is let
/// through.
#[test]
fn numbers_that_f32_does_not_hold_are_found() {
    let found = |text: &str| {
        let scene = load_toml("[[shapes]]\ntype = \"sphere\"\nemission = { radiance = 1 }\n");
        let mut scene = scene.expect("a valid scene");
        let shape = &mut scene.shapes[0];
        match text {
            "bright" => shape.emission.as_mut().unwrap().radiance.x = 1e39,
            "far" => scene.camera.eye.x = 1e20,
            "large" => shape.geometry = sphere(1e308),
            "small" => shape.geometry = sphere(1e-90),
            _ => {}
        }
        let refused = validate(&scene).is_err();
        (refused, sound::prepare(scene).is_err())
    };
    assert_eq!(found("as it is"), (false, false));
    for text in ["bright", "far", "large"] {
        assert_eq!(found(text), (true, true), "{text}");
    }
    // Refused for what rounding would do to its products in world space.
    assert!(found("small").0);
}

fn sphere(radius: f64) -> Geometry {
    let center = DVec3::ZERO;
    Geometry::Sphere { center, radius }
}

#[test]
fn kinds_of_messages_are_told_apart_by_their_words() {
    let kinds = [
        "DIR/a.toml: film.width: is 0; expected 1 to 32768 pixels",
        "DIR/a.toml: film.width: is -7; expected 1 to 32768 pixels",
        "DIR/a.toml: unknown key `a b` (line 3); expected `c`",
    ]
    .map(kind);
    assert_eq!(kinds[0], kinds[1]);
    assert_ne!(kinds[0], kinds[2]);
    assert_eq!(kinds[2], "unknown key expected ");
}
