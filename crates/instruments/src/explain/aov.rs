//! What the images beside radiance take.

use direkt::low_level::render::aov::FEATURE_SAMPLES;
use direkt::scene::{Aov, Aovs};
use serde::Serialize;

/// An AOV that is asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AovCost {
    /// Its name.
    pub name: String,
    /// What it takes.
    pub cost: String,
}

/// What each of `aovs` takes.
pub fn costs(aovs: Aovs) -> Vec<AovCost> {
    let costs = aovs.iter().map(|aov| AovCost {
        name: aov.to_string(),
        cost: cost(aov),
    });
    costs.collect()
}

fn cost(aov: Aov) -> String {
    match aov {
        Aov::Albedo | Aov::ShadingNormal => format!(
            "after the image, the camera paths of at most {FEATURE_SAMPLES} samples of each pixel; albedo and \
             shading-normal share them"
        ),
        Aov::GeometricNormal | Aov::Depth | Aov::Position | Aov::MaterialId | Aov::ObjectId => {
            "after the image, one ray per pixel, which all of its kind share".to_owned()
        }
        Aov::LightGroups => "the effect light-groups in the image's kernel".to_owned(),
        Aov::SampleCount | Aov::All => "nothing: every EXR has it".to_owned(),
    }
}
