//! Films of the reference, honest or broken, and the tests of image means that they and renders
//! share.

use super::statistics;
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::layout::SampleRecord;
use direkt::low_level::gpu::recorder::Recorder;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::broken::{BROKEN_TWINS, BrokenTwin};
use direkt::low_level::reference::{Sample, Twin};
use direkt::low_level::render::Film;
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::z_test::z_test;
use direkt::scene::{FilmSize, Sampler};
use glam::DVec3;

/// How far rounding in f32 may move a mean, relative to it (HARD CASES, pass criterion; positions
/// and offsets of rays add the rest).
const ROUNDING: f64 = 2e-5;

/// All mistakes but swapped sine and cosine, by which some means hardly change.
pub const COMMON_MISTAKES: [BrokenTwin; 5] = [
    BrokenTwin::PdfScaled,
    BrokenTwin::WrongMeasure,
    BrokenTwin::LightLeftOut,
    BrokenTwin::MisWeights,
    BrokenTwin::ExtraCosine,
];

/// Which light of a sample counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    All,
    /// What the surface reflects: without the lamps in sight, whose borders are the noise of many
    /// an image's mean.
    Reflected,
}

/// What a twin of `prepared` renders.
pub fn twin_film(
    prepared: &Prepared,
    (size, seed, samples): (FilmSize, u32, u64),
    part: Part,
    broken: Option<BrokenTwin>,
) -> Film {
    let twin = Twin::new(prepared, size, seed, broken);
    film_of(size, samples, |index| {
        let radiance = |s: &Sample| match part {
            Part::All => s.radiance,
            Part::Reflected => s.by_light + s.by_bsdf,
        };
        twin.samples(index).iter().map(radiance).collect()
    })
}

/// What the GPU's recorded samples of `prepared` make.
pub fn recorded_film(
    context: &Context,
    prepared: &Prepared,
    (size, seed, samples): (FilmSize, u32, u64),
    part: Part,
) -> Film {
    let recorder = Recorder::new(context, prepared, size, seed).unwrap();
    let vector = |rgb: [f32; 3]| DVec3::from_array(rgb.map(f64::from));
    film_of(size, samples, |index| {
        let radiance = |r: &SampleRecord| match part {
            Part::All => vector(r.radiance),
            Part::Reflected => vector(r.by_light) + vector(r.by_bsdf),
        };
        recorder
            .samples(index)
            .unwrap()
            .iter()
            .map(radiance)
            .collect()
    })
}

fn film_of(size: FilmSize, samples: u64, radiance: impl Fn(u64) -> Vec<DVec3>) -> Film {
    let mut sums = vec![[Moments::default(); 3]; size.pixels()];
    for index in 0..samples {
        for (sums, radiance) in sums.iter_mut().zip(radiance(index)) {
            assert!(radiance.is_finite(), "sample {index} is {radiance}");
            for (c, sum) in sums.iter_mut().enumerate() {
                sum.push(radiance[c]);
            }
        }
    }
    let mut film = Film::new(size, Sampler::Independent);
    for (pixel, sums) in film.pixels.iter_mut().zip(sums) {
        pixel.samples = samples;
        pixel.mean = sums.map(|m| m.mean);
        pixel.m2 = sums.map(|m| m.m2);
    }
    film
}

/// p-values of the channels' means being those of `other`. The variance is estimated, from 10⁵
/// samples or more.
pub fn same_means(film: &Film, other: &Film) -> [f64; 3] {
    let (mean, others) = (film.mean(), other.mean());
    let (error, others_error) = (standard_error(film), standard_error(other));
    std::array::from_fn(|c| {
        let variance = error[c].powi(2) + others_error[c].powi(2);
        z_test(mean[c], others[c], variance, ROUNDING * others[c].abs()).p_value
    })
}

/// p-values of the channels' means being `exact`, which is itself known to `allowance`.
pub fn exact_means(film: &Film, exact: [f64; 3], allowance: f64) -> [f64; 3] {
    let (mean, error) = (film.mean(), standard_error(film));
    std::array::from_fn(|c| {
        let allowance = ROUNDING * exact[c].abs() + allowance;
        z_test(mean[c], exact[c], error[c].powi(2), allowance).p_value
    })
}

fn standard_error(film: &Film) -> [f64; 3] {
    film.standard_error_of_mean().expect("two samples or more")
}

/// The channels' tests join the family.
pub fn accept_means(p_values: [f64; 3], what: &str) {
    for (p, channel) in p_values.into_iter().zip(["red", "green", "blue"]) {
        statistics::accept(p, &format!("{what}, {channel}"));
    }
}

/// Standard errors from which on a difference of means has to be found: the bound of a test of the
/// family, and 4 more for the noise.
fn findable() -> f64 {
    statistics::family().z_bound() + 4.0
}

/// Whether the mistake of `broken` shows in the noise of a test against `other`: whether its mean
/// differs from that of the honest twin so much in some channel. What is small in one scene shows
/// in another: see [`Power`].
fn shows(broken: &Film, honest: &Film, other_error: [f64; 3]) -> bool {
    let (means, error) = ((broken.mean(), honest.mean()), standard_error(broken));
    (0..3).any(|c| (means.0[c] - means.1[c]).abs() > findable() * error[c].hypot(other_error[c]))
}

/// The power of a test over several scenes and strategies: every broken twin whose mistake shows is
/// rejected, and each that is expected shows somewhere.
#[derive(Debug, Default)]
pub struct Power {
    found: Vec<BrokenTwin>,
}

impl Power {
    /// Runs the test of `p_values` on the broken twins of `prepared`. `other` is the film that they
    /// are compared with; none for an exact value.
    pub fn check(
        &mut self,
        prepared: &Prepared,
        (size, part): (FilmSize, Part),
        other: Option<&Film>,
        p_values: impl Fn(&Film) -> [f64; 3],
        what: &str,
    ) {
        let film = |broken| {
            let samples = samples(broken);
            twin_film(prepared, (size, 1000, samples), part, broken)
        };
        let honest = film(None);
        for row in BROKEN_TWINS.iter().filter(|r| (r.applies)(prepared)) {
            let broken = film(Some(row.twin));
            let error = other.map_or([0.0; 3], standard_error);
            if shows(&broken, &honest, error) {
                let p = p_values(&broken).into_iter().fold(1.0, f64::min);
                statistics::reject(p, &format!("{what}, {}", row.name));
                self.found.push(row.twin);
            }
        }
    }

    /// Fails unless each of `expected` was rejected somewhere.
    pub fn found(&self, expected: &[BrokenTwin]) {
        for twin in expected {
            assert!(self.found.contains(twin), "{twin:?} showed nowhere");
        }
    }
}

/// Samples per pixel: more where the mistake is of 2 %.
fn samples(broken: Option<BrokenTwin>) -> u64 {
    match broken {
        None | Some(BrokenTwin::PdfScaled | BrokenTwin::MisWeights) => 512,
        Some(
            BrokenTwin::WrongMeasure
            | BrokenTwin::SwappedSinCos
            | BrokenTwin::LightLeftOut
            | BrokenTwin::ExtraCosine
            | BrokenTwin::RaysForgotten
            | BrokenTwin::OpaqueShadows,
        ) => 64,
    }
}
