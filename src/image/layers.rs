//! AOVs as channels of an EXR; `docs/aov.md` lists them with the programs that look for their
//! names.

use super::exr::{Channel, single};
use crate::gpu::AdapterFacts;
use crate::gpu::features::Features;
use crate::prepare::Prepared;
use crate::render::aov::SurfacePoint;
use crate::render::{AovImages, Film};
use crate::scene::{Aov, Scene};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Depth of what lies beyond everything, as Blender writes it: an image has no infinity.
pub const BEYOND: f32 = 1e10;

const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// The channels of the AOVs that `prepared` asks for.
pub fn channels(prepared: &Prepared, film: &Film, images: &AovImages) -> Vec<Channel> {
    let mut channels = Vec::new();
    for aov in prepared.settings.aovs.iter() {
        match aov {
            Aov::LightGroups => channels.extend(of_light_groups(prepared, film)),
            // Every EXR has it.
            Aov::SampleCount | Aov::All => {}
            _ => {
                channels.extend(images.features.iter().flat_map(|f| of_features(aov, f)));
                channels.extend(images.surfaces.iter().flat_map(|s| of_surfaces(aov, s)));
            }
        }
    }
    channels
}

fn of_features(aov: Aov, features: &[Features]) -> Vec<Channel> {
    match aov {
        Aov::Albedo => triple("albedo", RGB, features, |f| f.albedo),
        Aov::ShadingNormal => triple("normal", XYZ, features, |f| f.normal),
        _ => Vec::new(),
    }
}

fn of_surfaces(aov: Aov, surfaces: &[Option<SurfacePoint>]) -> Vec<Channel> {
    let single = |name: &str, value: fn(&SurfacePoint) -> f64, nothing: f32| {
        let values = surfaces.par_iter();
        let values = values.map(|s| s.as_ref().map_or(nothing, |s| value(s) as f32));
        vec![(name.to_owned(), values.collect())]
    };
    let vector = |layer: &str, value: fn(&SurfacePoint) -> glam::DVec3| {
        triple(layer, XYZ, surfaces, |s| {
            s.as_ref().map_or([0.0; 3], |s| value(s).to_array())
        })
    };
    match aov {
        Aov::GeometricNormal => vector("N", |s| s.normal),
        Aov::Position => vector("P", |s| s.position),
        Aov::Depth => single("depth.Z", |s| s.depth, BEYOND),
        Aov::MaterialId => single("material_id.X", |s| f64::from(s.material.0 + 1), 0.0),
        Aov::ObjectId => single("object_id.X", |s| f64::from(s.shape.0 + 1), 0.0),
        _ => Vec::new(),
    }
}

fn of_light_groups(prepared: &Prepared, film: &Film) -> Vec<Channel> {
    let names = prepared.emitters.groups.names.iter();
    let groups = names.zip(&film.light_groups);
    let channels = groups
        .flat_map(|(name, image)| triple(&format!("Combined_{name}"), RGB, image, |&rgb| rgb));
    channels.collect()
}

/// Three channels of a layer.
fn triple<T: Sync>(
    layer: &str,
    names: [&str; 3],
    pixels: &[T],
    value: impl Fn(&T) -> [f64; 3] + Sync,
) -> Vec<Channel> {
    let channels = (0..).zip(names).map(|(c, name): (usize, _)| {
        let values = pixels.par_iter().map(|pixel| single(value(pixel)[c]));
        (format!("{layer}.{name}"), values.collect())
    });
    channels.collect()
}

/// How an image came about on `adapter`: scene, settings, samples per pixel.
pub fn render_attributes(
    prepared: &Prepared,
    film: &Film,
    adapter: &AdapterFacts,
) -> Vec<(&'static str, String)> {
    let settings = &prepared.settings;
    let mut attributes = vec![
        ("scene", prepared.data.scene.source.display().to_string()),
        ("adapter", adapter.name.clone()),
        ("driver", adapter.driver.clone()),
        ("seed", settings.seed.to_string()),
        ("spp", film.mean_samples().to_string()),
        ("direkt", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    attributes.extend(film.settings_of(settings.estimator).entries());
    attributes.extend(prepared.bias().map(|bias| ("biased", bias)));
    attributes
}

/// What belongs to the channels: names of the numbers in them, as JSON objects, and the samples of
/// averaged ones.
pub fn attributes(prepared: &Prepared, images: &AovImages) -> Vec<(&'static str, String)> {
    let aovs = prepared.settings.aovs;
    let mut attributes = Vec::new();
    if images.features.is_some() {
        attributes.push(("aov_samples", images.feature_samples.to_string()));
    }
    let Scene {
        materials, shapes, ..
    } = &prepared.data.scene;
    let seen = images.surfaces.iter().flatten().flatten();
    if aovs.contains(Aov::MaterialId) {
        let ids: BTreeSet<u32> = seen.clone().map(|s| s.material.0).collect();
        let names = manifest(&ids, |id| &materials[id].name);
        attributes.push(("material_ids", names));
    }
    if aovs.contains(Aov::ObjectId) {
        let ids: BTreeSet<u32> = seen.map(|s| s.shape.0).collect();
        attributes.push(("object_ids", manifest(&ids, |id| &shapes[id].name)));
    }
    if aovs.contains(Aov::LightGroups) {
        let names = prepared.emitters.groups.names.join(" ");
        attributes.push(("light_groups", names));
    }
    attributes
}

/// `{"1":"floor"}`: the names of the numbers that are seen, in ASCII, as EXR's text is Latin-1.
fn manifest<'a>(ids: &BTreeSet<u32>, name: impl Fn(usize) -> &'a String) -> String {
    let names: BTreeMap<u32, &String> = ids.iter().map(|&id| (id + 1, name(id as usize))).collect();
    let json = serde_json::to_string(&names).expect("numbers and names are JSON");
    let mut ascii = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            ascii.push(c);
        } else {
            for unit in c.encode_utf16(&mut [0; 2]) {
                ascii += &format!("\\u{unit:04x}");
            }
        }
    }
    ascii
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_are_ascii_json() {
        let names = ["floor".to_owned(), "Würfel \"𝄞\"".to_owned()];
        let text = manifest(&BTreeSet::from([1]), |id| &names[id]);
        assert!(text.is_ascii(), "{text}");
        let read: BTreeMap<String, String> = serde_json::from_str(&text).expect("JSON");
        assert_eq!(read, BTreeMap::from([("2".to_owned(), names[1].clone())]));
    }
}
