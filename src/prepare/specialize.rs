//! Kernels that are specialized for one scene: which scenes that pays for, and is exact enough for.

use super::Prepared;
use crate::accel::PrimitiveGeometry;
use crate::accel::build::FEW;
use crate::accel::flatten::Small;
use crate::effects::Effect;
use crate::scene::Camera;
use crate::scene::normalize::Normalization;
use glam::DVec3;
use std::ops::Range;

/// What rounding may put a ray off a plane's coordinates by, over the largest coordinate of what
/// it comes from and goes to: 16 units of rounding.
const ROUNDING: f64 = 16.0 / 16_777_216.0;
/// How many times as high as that every primitive has to be.
const LEAST_HEIGHT: f64 = 4096.0;

impl Prepared {
    /// Specializes the kernel where the scene is small, or a few of its primitives are large, and
    /// each of these is much larger than what neighbours overlap by.
    pub(super) fn call_for_specialization(&mut self) {
        if !self.settings.estimator.specialize {
            return;
        }
        let never = [
            Effect::Alpha,
            Effect::LogarithmicGrid,
            Effect::DistantCamera,
        ];
        let never = never.into_iter().any(|e| self.effects.contains(e));
        let all = &self.data.primitives;
        let written = self.written_out();
        let least = LEAST_HEIGHT * self.overlap();
        let fit = || {
            all[written.clone()]
                .iter()
                .all(|p| height(&p.geometry) >= least)
        };
        if !never && !written.is_empty() && fit() {
            let (count, all) = (written.len(), all.len());
            self.effects.call_for(Effect::SpecializedScene, || {
                if count == all {
                    format!("{count} primitives")
                } else {
                    format!("{count} large ones of {all} primitives")
                }
            });
        }
    }

    /// The primitives that stand in a specialized kernel as literals: all where they are few, else
    /// those that are large beside the others.
    pub fn written_out(&self) -> Range<usize> {
        let all = self.data.primitives.len();
        match &self.data.bvh.small {
            Some(small) => small.count..all,
            None if all <= FEW => 0..all,
            None => all..all,
        }
    }

    /// What a specialized kernel does not have as literals but loads, where that is anything.
    pub fn loaded(&self) -> Option<&Small> {
        let small = self.data.bvh.small.as_ref();
        small.filter(|_| self.effects.contains(Effect::SpecializedScene))
    }

    /// What neighbouring primitives of a specialized kernel overlap by, so that no ray passes
    /// between them: as far as rounding may put a ray off, normalised space.
    pub fn overlap(&self) -> f64 {
        ROUNDING * self.ray_reach
    }

    /// Whether rays of `camera` are no less exact than a specialized kernel takes them for.
    pub(super) fn is_specialized_for(&self, camera: &Camera) -> bool {
        !self.effects.contains(Effect::SpecializedScene)
            || ray_reach(&self.data.normalization, camera) <= self.ray_reach
    }
}

/// Largest coordinate of what rays of `camera` come from and go to, normalised space: a power of
/// two, so that a camera that moves seldom changes it.
pub(super) fn ray_reach(normalization: &Normalization, camera: &Camera) -> f64 {
    let eye = normalization.point(camera.eye).abs().max_element();
    eye.max(normalization.reach).log2().ceil().exp2()
}

/// The least distance between parallel lines in the plane of a primitive that it lies between; of
/// what is round the least diameter.
fn height(geometry: &PrimitiveGeometry) -> f64 {
    let of_edges = |u: DVec3, v: DVec3| u.cross(v).length() / u.length().max(v.length());
    match *geometry {
        PrimitiveGeometry::Triangle { u, v, .. } => {
            u.cross(v).length() / u.length().max(v.length()).max((u - v).length())
        }
        PrimitiveGeometry::Rectangle { u, v, .. } => of_edges(u, v),
        PrimitiveGeometry::Disk { u, v, .. } => 2.0 * of_edges(u, v),
        PrimitiveGeometry::Sphere { .. } | PrimitiveGeometry::Ellipsoid { .. } => f64::INFINITY,
    }
}
