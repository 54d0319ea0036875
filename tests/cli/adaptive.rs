//! Adaptive sampling from the command line and from a scene file.

use super::{cornell_with, run, text};
use serde_json::Value;

#[test]
fn adaptive_images_tell_their_samples() {
    let folder = tempfile::tempdir().unwrap();
    let scene = cornell_with("adaptive = false", folder.path());
    let [exr, json] = ["a.exr", "a.json"].map(|n| folder.path().join(n));
    let cases = [
        ("scenes/cornell.toml", vec![], true),
        ("scenes/cornell.toml", vec!["--adaptive=false"], false),
        (text(&scene), vec![], false),
        (text(&scene), vec!["--adaptive"], true),
    ];
    for (scene, flags, adaptive) in cases {
        let common = ["render", scene, "--spp", "64", "--size", "64x64"];
        let outputs = ["-o", text(&exr), "--json", text(&json)];
        let arguments: Vec<_> = common.into_iter().chain(outputs).chain(flags).collect();
        let (code, _, stderr) = run(&arguments);
        assert_eq!(code, 0, "{stderr}");
        let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        assert_eq!(report["adaptive"], adaptive);
        let [fewest, most] = [0, 1].map(|i| report["samples"][i].as_u64().unwrap());
        let spp = report["spp"].as_u64().unwrap();
        if adaptive {
            assert!(fewest >= 2 && fewest < spp && most >= 2 * spp, "{report}");
            assert!((64..128).contains(&spp), "{spp}");
        } else {
            assert_eq!((fewest, spp, most), (64, 64, 64));
        }
        let image = exr::prelude::read_all_flat_layers_from_file(&exr).unwrap();
        let other = &image.layer_data[0].attributes.other;
        assert!(other.contains_key(&exr::prelude::Text::from("adaptive")));
    }
}
