//! The random numbers of a camera ray's shadow rays; see `shaders/kernel/shadow_rays.wesl`.

use crate::emitters::Selection;
use crate::prepare::Prepared;
use crate::reference::core::rng::to_unit_2d;
use crate::reference::core::sampler::{
    GROUP_DIRECTION, GROUP_LIGHT, GROUP_LIGHT_POINTS, GROUP_LIGHT_TREE, Numbers, SampleId,
    independent_counter, part_of_sample,
};
use crate::scene::{ShadowGrid, ShadowPattern};
use glam::DVec2;

/// What a light sample is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightNumbers {
    /// Word that chooses the light.
    pub choice: u32,
    /// Word that chooses the environment's texel.
    pub texel: u32,
    /// Point on the light.
    pub point: DVec2,
    /// What the light tree's words beyond `choice` are hashed from.
    pub tree: [u32; 4],
}

/// How the shadow rays of a render get their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShadowRays {
    grid: ShadowGrid,
    pattern: ShadowPattern,
    /// Whether every light has rays of its own.
    own: bool,
    numbers: Numbers,
    part_numbers: Numbers,
}

impl ShadowRays {
    /// Those of a render of `prepared`, whose samples have `numbers`.
    pub fn new(prepared: &Prepared, numbers: Numbers) -> Self {
        let selection = &prepared.emitters.selection;
        Self {
            grid: prepared.shadow_grid(),
            pattern: prepared.shadow_pattern(),
            own: matches!(selection, Some(Selection::All(_))),
            numbers,
            part_numbers: Numbers {
                pattern: prepared.patterns().light,
                ..numbers
            },
        }
    }

    /// Shadow rays per camera ray, or per light with extent.
    pub fn rays(&self) -> u32 {
        self.grid.rays
    }

    /// The numbers of shadow ray `ray` of sample `id` to `light` (0 where lights are chosen).
    pub fn light_numbers(&self, id: SampleId, light: u32, ray: u32) -> LightNumbers {
        let part = part_of_sample(id, ray, self.grid.rays);
        let tree = independent_counter(part, GROUP_LIGHT_TREE);
        if self.pattern == ShadowPattern::Random {
            let group = if self.own {
                GROUP_LIGHT_POINTS.wrapping_add(light)
            } else {
                GROUP_LIGHT
            };
            let [x, y, choice, _] = self.part_numbers.group(part, group);
            return LightNumbers {
                choice,
                texel: self.part_numbers.group(part, GROUP_DIRECTION)[2],
                point: to_unit_2d(x, y),
                tree,
            };
        }
        let ahead = self.grid.steps.map(|step| ray.wrapping_mul(step));
        let choice = self.numbers.group(id, GROUP_LIGHT)[2];
        let texel = self.numbers.group(id, GROUP_DIRECTION)[2];
        LightNumbers {
            choice: choice.wrapping_add(ahead[0]),
            texel: texel.wrapping_add(ahead[1]),
            point: self.shadow_point(id, light, ray),
            tree,
        }
    }

    /// The point of shadow ray `ray` to `light`.
    fn shadow_point(&self, id: SampleId, light: u32, ray: u32) -> DVec2 {
        let middle = DVec2::splat(0.5);
        match self.pattern {
            ShadowPattern::Center => middle,
            ShadowPattern::Grid => grid_point(ray, self.grid, middle),
            ShadowPattern::Stratified | ShadowPattern::Random => {
                let first = light.wrapping_mul(self.grid.rays);
                let group = GROUP_LIGHT_POINTS.wrapping_add(first).wrapping_add(ray);
                let [x, y, ..] = self.numbers.group(id, group);
                grid_point(ray, self.grid, to_unit_2d(x, y))
            }
        }
    }
}

/// The point of cell `ray` of a grid, row by row, at the place `within` in [0, 1)² of it.
pub fn grid_point(ray: u32, grid: ShadowGrid, within: DVec2) -> DVec2 {
    let cell = DVec2::new(f64::from(ray % grid.columns), f64::from(ray / grid.columns));
    (cell + within) / DVec2::new(f64::from(grid.columns), f64::from(grid.rows))
}
