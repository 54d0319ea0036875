//! What images are held against: the mean of many.

use super::Image;
use crate::cost::reference::Reference;
use direkt::scene::ErrorMetric;

/// The mean of many images.
pub(super) struct Truth {
    reference: Reference,
    squared_mean: f64,
    images: f64,
    /// The mean's own NMSE and relMSE.
    own: [f64; 2],
}

impl Truth {
    pub(super) fn new(images: &[Image]) -> Self {
        let mut mean = vec![[0.0; 3]; images[0].mean.len()];
        let part = 1.0 / images.len() as f64;
        for image in images {
            for (mean, value) in mean.iter_mut().zip(&image.mean) {
                for c in 0..3 {
                    mean[c] += f64::from(value[c]) * part;
                }
            }
        }
        let overall = mean.iter().flatten().sum::<f64>() / (3 * mean.len()) as f64;
        let mut truth = Self {
            reference: Reference::exact(mean),
            squared_mean: overall * overall,
            images: images.len() as f64,
            own: [0.0; 2],
        };
        truth.own = [ErrorMetric::Nmse, ErrorMetric::RelMse].map(|metric| {
            let members = images.iter().map(|i| truth.of_member(&i.mean, metric));
            members.sum::<f64>() * part * part
        });
        truth
    }

    /// The error against the mean, as if that were the truth.
    fn against(&self, image: &[[f32; 3]], metric: ErrorMetric) -> f64 {
        let pixels = self.reference.mean.iter().zip(image);
        let terms = pixels.flat_map(|(truth, x)| {
            let term = |c: usize| {
                let off = f64::from(x[c]) - truth[c];
                off * off
                    * match metric {
                        ErrorMetric::Nmse => 1.0 / self.squared_mean,
                        ErrorMetric::RelMse => self.reference.weight(truth[c]),
                    }
            };
            [0, 1, 2].map(term)
        });
        terms.sum::<f64>() / (3 * image.len()) as f64
    }

    /// The error of one of the images that the mean is made of.
    pub(super) fn of_member(&self, image: &[[f32; 3]], metric: ErrorMetric) -> f64 {
        self.against(image, metric) * self.images / (self.images - 1.0)
    }

    /// The error of another image: the mean's own is taken off.
    pub(super) fn of_other(&self, image: &[[f32; 3]], metric: ErrorMetric) -> f64 {
        let own = match metric {
            ErrorMetric::Nmse => self.own[0],
            ErrorMetric::RelMse => self.own[1],
        };
        self.against(image, metric) - own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::low_level::render::{ImageError, StatedError};
    use direkt::low_level::stats::testing::Stream;

    /// Images of a ramp with normal errors of 10 %.
    fn images(count: usize) -> Vec<Image> {
        let mut stream = Stream::new(9);
        let stated = StatedError {
            value: 0.01,
            low: 0.0,
            high: 1.0,
            doubt: None,
        };
        let reported = ImageError {
            nmse: stated,
            rel_mse: stated,
            confidence: 0.95,
        };
        let mut pixel = |i: usize| [0; 3].map(|_| (ramp(i) * (1.0 + 0.1 * stream.normal())) as f32);
        (0..count)
            .map(|_| Image {
                mean: (0..1000).map(&mut pixel).collect(),
                reported,
            })
            .collect()
    }

    fn ramp(i: usize) -> f64 {
        0.5 + i as f64 / 1000.0
    }

    #[test]
    fn the_mean_of_all_images_stands_for_the_truth() {
        let all = images(12);
        let (of_truth, other) = all.split_at(8);
        let truth = Truth::new(of_truth);
        // relMSE = 0.01 · mean of r²/(r² + 0.01·mean(r)²); 3000 squares of normal numbers, eight
        // images: 1 % is two sigma.
        let due = (0..1000).map(|i| ramp(i).powi(2) / (ramp(i).powi(2) + 0.01));
        let due = 0.01 * due.sum::<f64>() / 1000.0;
        let of = |error: &dyn Fn(&[[f32; 3]]) -> f64, images: &[Image]| {
            let sum: f64 = images.iter().map(|i| error(&i.mean)).sum();
            sum / images.len() as f64 / due
        };
        let metric = ErrorMetric::RelMse;
        let members = of(&|i| truth.of_member(i, metric), of_truth);
        assert!((members - 1.0).abs() < 0.05, "{members}");
        let others = of(&|i| truth.of_other(i, metric), other);
        assert!((others - 1.0).abs() < 0.05, "{others}");
        let unscaled = of(&|i| truth.against(i, metric), of_truth);
        assert!(
            unscaled < 0.92,
            "an eighth of its own error is in the mean: {unscaled}"
        );
    }
}
