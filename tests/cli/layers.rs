//! How other programs find their way in an EXR: by layers, which names before the last dot make.

use super::{run, text};
use exr::prelude::{AttributeValue, FlatImage, read_all_flat_layers_from_file};
use std::collections::BTreeMap;

/// The bits of the channels by name.
fn channels(image: &FlatImage) -> BTreeMap<String, Vec<u32>> {
    let channels = image.layer_data[0].channel_data.list.iter();
    let bits = |c: &exr::prelude::AnyChannel<exr::prelude::FlatSamples>| {
        let values = c.sample_data.values_as_f32().map(f32::to_bits);
        (c.name.to_string(), values.collect())
    };
    channels.map(bits).collect()
}

#[test]
fn the_layer_of_colours_holds_nothing_else_and_plain_files_nothing_but_it() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, flags: &[&str]| {
        let exr = folder.path().join(name);
        let base = ["render", "scenes/cornell.toml", "--spp", "3", "-q"];
        let output = ["--size", "24x16", "-o", text(&exr)];
        let (code, _, stderr) = run(&[&base[..], &output, flags].concat());
        assert_eq!((code, stderr.as_str()), (0, ""));
        read_all_flat_layers_from_file(&exr).unwrap()
    };
    let layered = channels(&render("layers.exr", &[]));
    let root: Vec<_> = layered.keys().filter(|n| !n.contains('.')).collect();
    assert_eq!(root, ["B", "G", "R"]);
    let image = render("❤.exr", &["--plain"]);
    let plain = channels(&image);
    assert_eq!(plain.keys().collect::<Vec<_>>(), ["B", "G", "R"]);
    assert!(plain.iter().all(|(name, bits)| bits == &layered[name]));
    let other = &image.layer_data[0].attributes.other;
    let command = other.iter().find(|(name, _)| **name == *"command");
    let Some((_, AttributeValue::Text(command))) = command else {
        panic!("{command:?}");
    };
    let command = std::str::from_utf8(command.as_slice()).unwrap();
    assert!(command.contains("❤.exr --plain"), "{command}");
}

#[test]
fn plain_files_cannot_hold_what_is_asked_for_beside_colours() {
    for (flags, named) in [
        (&["-o", "a.exr", "--aov", "depth"][..], "--aov"),
        (&["-o", "a.png"], "-o out.exr"),
        (&["--check"], "--output"),
    ] {
        let base = ["render", "scenes/tests/sky.toml", "--plain"];
        let (code, _, stderr) = run(&[&base[..], flags].concat());
        assert_eq!(code, 2, "{flags:?}: {stderr}");
        assert!(stderr.contains(named), "{flags:?}: {stderr}");
    }
}
