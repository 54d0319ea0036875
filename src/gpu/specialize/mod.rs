//! Kernels that are specialized for a small scene: what there is to load of it stands in the shader
//! as literals, so that nothing is left to load and no hierarchy to walk. Of a large scene the few
//! large primitives do, so that only rays that come near the others walk the hierarchy over these.
//!
//! On a driver in software a load whose address differs between lanes costs a branch per lane, and
//! the loads of a sample are most of its time. A primitive that is known while the kernel is
//! compiled costs a few multiplications instead.
//!
//! Made from the words that the buffers would hold, so that both kernels read the same numbers.

mod bounds;
mod boxes;
mod condition;
mod expressions;
mod geometry;
mod tables;

use super::gpu_scene::primitive_words;
use super::layout::{LIGHT_WORDS, MATERIAL_WORDS};
use super::lights::light_words;
use super::materials::material_words;
use super::textures::atlases;
use crate::effects::Effect;
use crate::prepare::Prepared;
use std::fmt::Write as _;
use std::sync::Arc;

const IMPORTS: &str = "\
import package::core::bvh::{larger, smaller};
import package::core::constants::{NONE, T_MAX};
import package::core::ray::{Hit, Ray};
import package::core::ray_ellipsoid::intersect_ellipsoid;
import package::core::ray_sphere::intersect_sphere;
import package::scene::fetch::{LightRecord, MaterialRecord, PrimitiveRecord};

";

/// Most materials that are written out.
const MAX_MATERIALS: usize = 32;
/// Most lights that are written out.
const MAX_LIGHTS: usize = 16;

/// The module `package::specialized`, and what of the scene it holds beside the geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpecializedScene {
    text: Arc<str>,
    materials: bool,
    lights: bool,
    /// Whether there are primitives, and some that emit, which are loaded.
    loaded_primitives: bool,
    loaded_emitters: bool,
}

impl SpecializedScene {
    /// That of `prepared`, where the kernel is specialized for its scene.
    pub(super) fn of(prepared: &Prepared) -> Option<Self> {
        if !prepared.effects.contains(Effect::SpecializedScene) {
            return None;
        }
        let any = |of: &[Effect]| of.iter().any(|e| prepared.effects.contains(*e));
        let varied = [
            Effect::ColorTexture,
            Effect::RoughnessTexture,
            Effect::GlossinessTexture,
            Effect::NormalMap,
            Effect::VertexColors,
        ];
        let scene = &prepared.data.scene;
        let materials = scene.materials.len() <= MAX_MATERIALS && !any(&varied);
        let emitters = &prepared.emitters;
        let lights = (1..=MAX_LIGHTS).contains(&emitters.lights.len())
            && emitters.maps.is_empty()
            && !any(&[Effect::LightTree]);
        let written = prepared.written_out();
        let mut text = IMPORTS.to_owned();
        let _ = writeln!(text, "const FIRST_WRITTEN: u32 = {}u;\n", written.start);
        text.push_str(&geometry::functions(prepared));
        let loaded_primitives = prepared.loaded().is_some();
        if !loaded_primitives {
            text.push_str(&tables::primitives(&primitive_words(prepared)));
        }
        if materials {
            let [colors, data] = atlases(scene);
            let words = material_words(prepared, [&colors, &data]).words;
            let words = &words[..MATERIAL_WORDS as usize * scene.materials.len()];
            text.push_str(&tables::materials(words));
        }
        if lights {
            let words = light_words(prepared, &[]);
            let words = &words[..LIGHT_WORDS as usize * emitters.lights.len()];
            text.push_str(&tables::lights(words));
        }
        Some(Self {
            text: text.into(),
            materials,
            lights,
            loaded_primitives,
            loaded_emitters: !emitters
                .primitives()
                .all(|p| written.contains(&(p as usize))),
        })
    }

    /// The module's text.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// WESL features with their values. That of the effect is among them: without the module there is
    /// nothing that it could compile in.
    pub(super) fn features(of: Option<&Self>) -> [(&'static str, bool); 5] {
        [
            (Effect::SpecializedScene.feature(), of.is_some()),
            ("SPECIALIZED_MATERIALS", of.is_some_and(|s| s.materials)),
            ("SPECIALIZED_LIGHTS", of.is_some_and(|s| s.lights)),
            ("LOADED_PRIMITIVES", of.is_some_and(|s| s.loaded_primitives)),
            ("LOADED_EMITTERS", of.is_some_and(|s| s.loaded_emitters)),
        ]
    }
}
