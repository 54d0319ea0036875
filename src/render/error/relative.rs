//! relMSE, whose denominators a noisy image has to guess.

use super::chance::SquaredError;
use super::denominators::{smoothed, squared_truth};
use super::doubt::Doubt;
use super::evidence::Evidence;
use super::missed::MissedLight;
use super::{CONFIDENCE, StatedError, TOLD};
use crate::render::film::{Film, Pixel};
use crate::stats::interval::Interval;
use crate::stats::sums::sum;
use rayon::prelude::*;

/// relMSE with the interval for `confidence`; 1 % of the squared mean is the `floor` of what it
/// divides by.
///
/// In the denominators D stands what the image suggests for the truth r. Its noise, of variance ρV,
/// is of two consequences. By chance D = r² is off by 2r√(ρV), pixel by pixel, which adds 4ρ(V/D)³
/// to the variance of the pixel's term. On the whole it makes the estimate too small or too large,
/// as errors are skewed or not; how much it may be is told by denominators with their noise added
/// to them, and the interval is so much wider. Its upper end allows besides for pixels that are
/// bright by chance: their denominators may be those that the lesser replicate and the pixels around
/// suggest.
pub(super) fn relative(
    film: &Film,
    evidence: &Evidence,
    missed: &MissedLight,
    (floor, confidence): (f64, f64),
) -> Option<StatedError> {
    let truth = squared_truth(film, evidence)?;
    let part = 1.0 / (3.0 * film.pixels.len() as f64);
    let denominator = |i: usize, c: usize| truth[i][c].square + floor;
    let mut error = SquaredError::of_two(evidence, |i| [0, 1, 2].map(|c| part / denominator(i, c)));
    let pixels = evidence.pixels.par_iter().zip(&truth);
    let terms = pixels.enumerate().map(|(i, (pixel, truth))| {
        let (mut with_noise, mut at_most, mut by_chance) = (0.0, 0.0, 0.0);
        for (c, truth) in truth.iter().enumerate() {
            let (estimate, d) = (part * pixel.squared[c], denominator(i, c));
            with_noise += estimate / (d + truth.noise * pixel.squared[c]);
            at_most += estimate / (truth.least + floor);
            by_chance += 12.0 * part * part * truth.noise * (pixel.variance[c] / d).powi(3);
        }
        [with_noise, at_most, by_chance]
    });
    let [with_noise, at_most, by_chance] = sum(terms);
    let (above, below) = (error.sum - with_noise, at_most - error.sum);
    error.variance += by_chance;
    let stated = |confidence: f64| {
        let Interval { value, low, high } = error.interval(confidence);
        if value <= 0.0 {
            return Interval { value, low, high };
        }
        // What denominators may do is no chance that would average out: it comes on top.
        Interval {
            value,
            low: (value - above).max(0.0) * (low / value),
            high: (value + above.max(below)) * (high / value),
        }
    };
    let Interval { value, low, high } = stated(confidence);
    let by_others = cross_fitted(film, evidence, (part, floor))?;
    let doubt = if error.interval(CONFIDENCE).high > TOLD * value {
        Some(error.doubt())
    } else if stated(CONFIDENCE).high.max(by_others) > TOLD * value {
        Some(Doubt::Denominators)
    } else {
        None
    };
    let weight = |i: usize| (0..3).map(|c| part / (3.0 * denominator(i, c))).sum();
    let error = StatedError {
        value,
        low,
        high,
        doubt,
    };
    Some(error.beside(missed.sum(value, weight)))
}

/// The same with denominators that know nothing of the errors above them: each replicate's variance
/// over the square of the other (cross-fitting; Chernozhukov et al. 2018, "Double/debiased machine
/// learning").
///
/// What is bright by chance in one replicate does not hide its error here; what is dark by chance
/// makes it too large. On the whole it is too large, as 1/x is convex: an upper bound rather than an
/// estimate.
fn cross_fitted(film: &Film, evidence: &Evidence, (part, floor): (f64, f64)) -> Option<f64> {
    let replicates: Option<Vec<_>> = film.pixels.par_iter().map(Pixel::replicates).collect();
    let replicates = replicates?;
    let weights = [0, 1].map(|which| {
        let values: Vec<_> = replicates.par_iter().map(|r| r[which]).collect();
        // A replicate has half the samples, and twice the variance of the image.
        let pixels = evidence.pixels.par_iter();
        let noise: Vec<_> = pixels
            .map(|p| p.by_replicate[which].map(|v| 2.0 * v))
            .collect();
        let smooth = smoothed(&values, &noise, evidence);
        let weight = |x: [f64; 3]| x.map(|x| part / (x * x + floor));
        smooth.into_par_iter().map(weight).collect::<Vec<_>>()
    });
    let terms = evidence.pixels.par_iter().enumerate().map(|(i, pixel)| {
        let [first, second] = pixel.by_replicate;
        let of_channel = |c: usize| first[c] * weights[1][i][c] + second[c] * weights[0][i][c];
        [0.5 * (of_channel(0) + of_channel(1) + of_channel(2))]
    });
    let [sum] = sum(terms);
    Some(sum)
}
