//! Pixels that are asked, before a render begins, how many shadow rays pay.
//!
//! A second shadow ray costs less than a second camera ray, and makes what lights add more certain,
//! but not where a pixel's filter, the lens, a texture or an edge brings the noise (the classical
//! trade between splitting and more samples, Hammersley & Handscomb 1964, section 5.2). Which it is
//! a scene does not tell: a few pixels take the same samples with one and with several shadow rays.
//! Their samples are no part of the image, whose means so know nothing of the choice.

use super::film::Pixel;
use crate::gpu::layout::PixelState;
use crate::scene::{FilmSize, Sampler};

/// Index of their first sample, far from those of images and pilots.
pub(super) const FIRST: u64 = 1 << 34;
/// Samples that each takes.
pub(super) const SAMPLES: u32 = 8;
/// Scouts in an image, about, where it is large.
const MOST: f64 = 4096.0;
/// The largest part of an image that they are.
const LARGEST_PART: f64 = 1.0 / 16.0;
/// What a camera ray costs beside tracing it, in rays.
const OVERHEAD: f64 = 0.5;
/// The power of the number of samples by which squared errors fall with samplers that stratify, and
/// with samples that are drawn each by itself.
const STRATIFIED: f64 = 1.25;
const INDEPENDENT: f64 = 1.0;

/// Whether the pixel (x, y) of an image of `size` is one: they lie on a lattice, spread evenly.
pub(super) fn is_scout((x, y): (u32, u32), size: FilmSize) -> bool {
    // The generators of the additive recurrence that is best in two dimensions, 1/g and 1/g² of the
    // real root g of g³ = g + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom
    // sequences"), in units of 2⁻³².
    let at = x
        .wrapping_mul(3_242_174_889)
        .wrapping_add(y.wrapping_mul(2_447_445_414));
    let part = (MOST / size.pixels() as f64).min(LARGEST_PART);
    f64::from(at) < part * 2.0_f64.powi(32)
}

/// Whether several shadow rays are sooner at the same error than one, by what the same scouts have
/// with `one` and with `several`: in an image of `sampler`, whose samples are shared out by where
/// the error is if it is `adaptive`.
pub(super) fn pay(
    one: &[PixelState],
    several: &[PixelState],
    (sampler, adaptive): (Sampler, bool),
) -> bool {
    let power = if sampler.is_independent() {
        INDEPENDENT
    } else {
        STRATIFIED
    };
    let time = time_of_sample(several) / time_of_sample(one);
    let [one, several] = errors(one, several, adaptive);
    let gain = (one[0] / several[0] * (one[1] / several[1])).sqrt();
    gain > time.powf(power)
}

/// About what a sample costs, in rays.
fn time_of_sample(states: &[PixelState]) -> f64 {
    let rays = |s: &PixelState| f64::from(s.shadow_rays) + f64::from(s.bsdf_rays);
    let rays: f64 = states.iter().map(rays).sum();
    let samples: f64 = states.iter().map(|s| f64::from(s.samples)).sum();
    1.0 + OVERHEAD + rays / samples.max(1.0)
}

/// What two images of the same pixels promise of an NMSE and a relMSE, in units that both share:
/// sums of squared errors, or where samples are shared out in proportion to the roots of these, as
/// is best, the squares of the sums of the roots (Neyman 1934).
fn errors(one: &[PixelState], several: &[PixelState], adaptive: bool) -> [[f64; 2]; 2] {
    let told = |state: &PixelState| -> Option<(f64, [f64; 3])> {
        let mut pixel = Pixel::default();
        pixel.merge(state);
        let squares = pixel.half_difference()?.iter().map(|h| h * h).sum();
        Some((squares, pixel.mean))
    };
    let pairs = one.iter().zip(several);
    let pairs: Vec<_> = pairs
        .filter_map(|(one, several)| Some((told(one)?, told(several)?)))
        .collect();
    let value =
        |[a, b]: [[f64; 3]; 2]| -> f64 { (0..3).map(|c| (0.5 * (a[c] + b[c])).powi(2)).sum() };
    let values: Vec<f64> = pairs.iter().map(|(a, b)| value([a.1, b.1])).collect();
    let floor = 0.01 * values.iter().sum::<f64>() / values.len() as f64;
    let sums_of = |power: f64| {
        let mut sums = [[0.0; 2]; 2];
        for ((one, several), value) in pairs.iter().zip(&values) {
            let relative = (value + floor).max(f64::MIN_POSITIVE);
            for (sums, squares) in sums.iter_mut().zip([one.0, several.0]) {
                sums[0] += squares.powf(power);
                sums[1] += (squares / relative).powf(power);
            }
        }
        sums
    };
    if adaptive {
        sums_of(0.5).map(|sums| sums.map(|roots| roots * roots))
    } else {
        sums_of(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: FilmSize = FilmSize {
        width: 640,
        height: 360,
    };

    #[test]
    fn scouts_are_spread_evenly() {
        let rows = |from: u32| (from..from + 90).flat_map(|y| (0..640).map(move |x| (x, y)));
        for from in [0, 90, 180, 270] {
            for column in 0..4 {
                let here = rows(from).filter(|(x, _)| x / 160 == column);
                let scouts = here.filter(|pixel| is_scout(*pixel, SIZE)).count();
                assert!(
                    scouts.abs_diff(4096 / 16) <= 8,
                    "{from}, {column}: {scouts}"
                );
            }
        }
        let small = FilmSize {
            width: 32,
            height: 32,
        };
        let all = (0..32).flat_map(|y| (0..32).map(move |x| (x, y)));
        let scouts = all.filter(|pixel| is_scout(*pixel, small)).count();
        assert!(scouts.abs_diff(64) <= 4, "{scouts}");
    }

    /// Scouts with a mean of one whose replicates are `half` of it apart on either side, and `rays`
    /// shadow rays per sample.
    fn scouts(half: f32, rays: u32) -> Vec<PixelState> {
        let state = PixelState {
            mean: [1.0; 3],
            samples: SAMPLES,
            second_mean: [1.0 - half; 3],
            second_samples: SAMPLES / 2,
            shadow_rays: rays * SAMPLES,
            ..PixelState::default()
        };
        vec![state; 100]
    }

    /// A sample of one shadow ray takes 2.5 rays, one of four 5.5.
    #[test]
    fn several_pay_where_the_error_falls_faster_than_the_time_rises() {
        let one = scouts(0.1, 1);
        let falls_by = |squared: f32| scouts(0.1 / squared.sqrt(), 4);
        for adaptive in [false, true] {
            let pays = |squared, sampler| pay(&one, &falls_by(squared), (sampler, adaptive));
            assert!(pays(2.3, Sampler::Independent) && !pays(2.1, Sampler::Independent));
            // More samples instead help more where they stratify: 2.2^1.25 = 2.68.
            assert!(pays(2.8, Sampler::Sobol) && !pays(2.5, Sampler::Sobol));
        }
    }

    #[test]
    fn one_is_enough_where_nothing_is_seen() {
        let black = vec![PixelState::default(); 100];
        assert!(!pay(&black, &black, (Sampler::Sobol, true)));
        assert!(!pay(&[], &[], (Sampler::Sobol, true)));
        let still = scouts(0.0, 1);
        assert!(!pay(&still, &still, (Sampler::Sobol, true)));
    }

    /// Where samples are shared out, a pixel that several rays do not help has them anyway.
    #[test]
    fn one_pixel_does_not_decide_where_samples_are_shared_out() {
        let (mut one, mut several) = (scouts(0.1, 1), scouts(0.04, 4));
        (one[7], several[7]) = (scouts(1.0, 1)[0], scouts(1.0, 4)[0]);
        assert!(pay(&one, &several, (Sampler::Sobol, true)));
        assert!(!pay(&one, &several, (Sampler::Sobol, false)));
    }
}
