//! Groups of lights and AOVs in scene files.

use super::files::{Folder, refused};
use direkt::scene::light_groups::MAX_LIGHT_GROUPS;
use direkt::scene::{Aov, Scene, ShapeId};

fn load(text: &str) -> Scene {
    let folder = Folder::new();
    folder.write("scene.toml", text);
    folder.load("scene.toml").unwrap()
}

#[test]
fn lights_shapes_and_the_environment_name_their_groups() {
    let scene = load(
        "[[shapes]]\ntype = \"sphere\"\n\
         [[shapes]]\ntype = \"box\"\nemission = { radiance = 1, group = \"cube\" }\n\
         [[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n\
         [[lights]]\ntype = \"point\"\nposition = [0, 4, 0]\nintensity = 1\ngroup = \"key\"\n\
         [environment]\nradiance = 1\ngroup = \"key\"\n[render]\naovs = [\"light-groups\", \"depth\"]\n",
    );
    let groups = &scene.light_groups;
    assert_eq!(groups.names(), ["cube", "key"]);
    assert_eq!(groups.of_shape(ShapeId(0)), None);
    assert_eq!(
        groups.of_shape(ShapeId(6)),
        Some(0),
        "every face of the box"
    );
    assert_eq!([0, 1].map(|i| groups.of_light(i)), [None, Some(1)]);
    assert_eq!(groups.of_environment(), Some(1));
    let aovs = scene.render.aovs;
    assert!(aovs.contains(Aov::LightGroups) && aovs.contains(Aov::Depth));
    assert!(!aovs.contains(Aov::Albedo));
}

#[test]
fn bad_names_are_refused() {
    let light = "[[lights]]\ntype = \"point\"\nposition = [0, 3, 0]\nintensity = 1\n";
    assert_eq!(
        refused(&format!("{light}group = \"key.fill\"\n")),
        "DIR/scene.toml: lights[0].group: is \"key.fill\"; expected a name of 1 to 64 letters, digits, `_` or `-`"
    );
    let message = refused("[render]\naovs = [\"depth\", \"albdo\"]\n");
    for word in ["render.aovs[1]", "albdo", "albedo", "sample-count"] {
        assert!(message.contains(word), "{message}");
    }
    let shape = "[[shapes]]\ntype = \"sphere\"\ngroup = \"a\"\n";
    assert!(refused(shape).contains("group"), "{}", refused(shape));
    let many: String = (0..MAX_LIGHT_GROUPS)
        .map(|i| format!("{light}group = \"g{i}\"\n"))
        .collect();
    assert_eq!(
        refused(&many),
        "DIR/scene.toml: group: has 64 different names in the scene; expected at most 63 groups of lights"
    );
}
