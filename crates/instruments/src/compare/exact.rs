//! The GPU's samples against exact direct lighting at the very points that their camera rays meet.
//!
//! A sample minus the exact radiance along its camera ray has mean zero, whatever the pixel shows:
//! the film's noise drops out, and no reference noise enters.

use super::per_pixel::ROUNDING;
use super::{EXACT_FAMILY, radiance};
use direkt::low_level::gpu::layout::SampleRecord;
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::exact::cubature::Estimate;
use direkt::low_level::reference::exact::scene::{ExactScene, NotExact};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Points at which glossy surfaces are integrated numerically.
const GLOSSY_POINTS: usize = 1 << 13;
/// Samples of every pixel that are compared where all surfaces are diffuse.
const DIFFUSE_SAMPLES: u64 = 8;

/// How a channel compares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelResidual {
    /// Mean of the exact radiances.
    pub exact: f64,
    /// Mean of GPU minus exact.
    pub difference: f64,
    /// Half the width of its 95 % confidence interval.
    pub half_width: f64,
    /// The difference in standard errors, beyond rounding and the cubature's own error.
    pub z: f64,
    /// Probability of one as large.
    pub p_value: f64,
}

/// How samples compare with exact answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exact {
    /// Samples compared.
    pub samples: u64,
    /// Mean error bound of the exact answers.
    pub error: f64,
    /// Red, green, blue.
    pub channels: [ChannelResidual; 3],
    /// Level of the three tests together.
    pub family_level: f64,
}

impl Exact {
    /// Whether no channel differs.
    pub fn agrees(&self) -> bool {
        let rejects = |c: &ChannelResidual| EXACT_FAMILY.rejects(c.p_value);
        !self.channels.iter().any(rejects)
    }
}

/// Sums while samples come.
#[derive(Debug)]
pub(super) struct Accumulator<'a> {
    scene: ExactScene<'a>,
    twin: &'a Twin<'a>,
    width: u32,
    residuals: [Moments; 3],
    exact: DVec3,
    error: f64,
}

impl<'a> Accumulator<'a> {
    /// Nothing compared yet.
    ///
    /// # Errors
    /// The scene has no exact answers.
    pub(super) fn new(twin: &'a Twin<'a>, width: u32) -> Result<Self, NotExact> {
        Ok(Self {
            scene: ExactScene::new(twin.direct().world())?,
            twin,
            width,
            residuals: [Moments::default(); 3],
            exact: DVec3::ZERO,
            error: 0.0,
        })
    }

    /// Compares sample `index` of every pixel, as far as the scene is worth it.
    pub(super) fn add(&mut self, index: u64, gpu: &[SampleRecord]) {
        let stride = if self.scene.is_diffuse() {
            if index >= DIFFUSE_SAMPLES {
                return;
            }
            1
        } else {
            let samples = (GLOSSY_POINTS / gpu.len()).max(1) as u64;
            if index >= samples {
                return;
            }
            gpu.len().div_ceil(GLOSSY_POINTS)
        };
        let pixels: Vec<usize> = (0..gpu.len()).step_by(stride).collect();
        let exact: Vec<Estimate> = pixels
            .par_iter()
            .map(|&i| {
                let (x, y) = (i as u32 % self.width, i as u32 / self.width);
                let ray = self.twin.direct().camera_ray(x, y, index);
                self.scene.radiance(&ray)
            })
            .collect();
        for (&i, exact) in pixels.iter().zip(&exact) {
            let residual = radiance(&gpu[i]) - exact.value;
            for (c, moments) in self.residuals.iter_mut().enumerate() {
                moments.push(residual[c]);
            }
            self.exact += exact.value;
            self.error += exact.error;
        }
    }

    /// The result.
    pub(super) fn finish(self) -> Exact {
        let n = self.residuals[0].count.max(1) as f64;
        let error = self.error / n;
        let channels = std::array::from_fn(|c| {
            let residual = &self.residuals[c];
            let variance = residual.variance_of_mean().unwrap_or(0.0);
            let exact = self.exact[c] / n;
            let allowance = ROUNDING * exact.abs() + error;
            let test = z_test(residual.mean, 0.0, variance, allowance);
            ChannelResidual {
                exact,
                difference: residual.mean,
                half_width: 1.959_963_984_540_054 * variance.sqrt(),
                z: test.z,
                p_value: test.p_value,
            }
        });
        Exact {
            samples: self.residuals[0].count,
            error,
            channels,
            family_level: EXACT_FAMILY.level,
        }
    }
}
