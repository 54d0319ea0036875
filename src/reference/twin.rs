//! The twin: every sample of an image, in f64, on all cores.

use super::broken::BrokenTwin;
use super::kernel::direct::Direct;
use super::kernel::sample::Sample;
use crate::prepare::Prepared;
use crate::scene::FilmSize;
use rayon::prelude::*;

/// The estimator in f64.
#[derive(Debug)]
pub struct Twin<'a> {
    direct: Direct<'a>,
    size: FilmSize,
}

impl<'a> Twin<'a> {
    /// The twin of a render of `prepared` at `size` pixels with `seed`; `broken` gives it one
    /// mistake.
    pub fn new(
        prepared: &'a Prepared,
        size: FilmSize,
        seed: u32,
        broken: Option<BrokenTwin>,
    ) -> Self {
        let direct = Direct::new(prepared, size, seed, broken);
        Self { direct, size }
    }

    /// The estimator of a single sample.
    pub fn direct(&self) -> &Direct<'a> {
        &self.direct
    }

    /// The twin where only the lights of `group` shine; everything is sampled as before.
    #[must_use]
    pub fn with_light_group(self, group: u32) -> Self {
        Self {
            direct: self.direct.with_light_group(group),
            ..self
        }
    }

    /// The twin with other random numbers.
    #[must_use]
    pub fn with_seed(self, seed: u32) -> Self {
        Self {
            direct: self.direct.with_seed(seed),
            ..self
        }
    }

    /// Sample `index` of every pixel, row by row.
    pub fn samples(&self, index: u64) -> Vec<Sample> {
        let width = self.size.width;
        let pixels = 0..self.size.pixels() as u32;
        pixels
            .into_par_iter()
            .map(|p| self.direct.sample_radiance(p % width, p / width, index))
            .collect()
    }
}
