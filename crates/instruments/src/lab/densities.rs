//! The densities and discrete distributions that [`sampling`](super::sampling) draws from, in f64.

use direkt::scene::alias_table::AliasTable;
use std::f64::consts::PI;

/// A density on an interval, `shaders/lab/densities.wesl`.
#[derive(Debug, Clone, Copy)]
pub struct Density {
    /// Its formula.
    pub name: &'static str,
    /// Name of the plot's file.
    pub file: &'static str,
    /// The interval.
    pub interval: [f64; 2],
    /// Per unit length.
    pub pdf: fn(f64) -> f64,
    /// From 0 at the interval's begin to 1 at its end.
    pub cdf: fn(f64) -> f64,
    /// The density's maximum.
    pub largest: f64,
    /// How the distribution function is inverted.
    pub inverse: &'static str,
}

const EXPONENTIAL_MASS: f64 = 0.950_212_931_632_136;

/// All, in the order of the shader's numbers.
pub const DENSITIES: [Density; 5] = [
    Density {
        name: "x/8 on [0, 4]",
        file: "sampling-linear",
        interval: [0.0, 4.0],
        pdf: |x| x / 8.0,
        cdf: |x| x * x / 16.0,
        largest: 0.5,
        inverse: "4√u",
    },
    Density {
        name: "e^−x/(1 − e^−3) on [0, 3]",
        file: "sampling-exponential",
        interval: [0.0, 3.0],
        pdf: |x| (-x).exp() / EXPONENTIAL_MASS,
        cdf: |x| -(-x).exp_m1() / EXPONENTIAL_MASS,
        largest: 1.0 / EXPONENTIAL_MASS,
        inverse: "−ln(1 − u(1 − e^−3))",
    },
    Density {
        name: "sin 2θ on [0, π/2]",
        file: "sampling-polar",
        interval: [0.0, PI / 2.0],
        pdf: |x| (2.0 * x).sin().max(0.0),
        cdf: |x| x.sin().powi(2),
        largest: 1.0,
        inverse: "asin √u",
    },
    Density {
        name: "(4/π)√(1 − x²) on [0, 1]",
        file: "sampling-semicircle",
        interval: [0.0, 1.0],
        pdf: |x| 4.0 / PI * (1.0 - x * x).max(0.0).sqrt(),
        cdf: |x| 2.0 / PI * (x * (1.0 - x * x).max(0.0).sqrt() + x.min(1.0).asin()),
        largest: 4.0 / PI,
        inverse: "none: 24 halvings",
    },
    Density {
        name: "∝ 1/(1 + 400x²) on [−1, 1]",
        file: "sampling-peak",
        interval: [-1.0, 1.0],
        pdf: |x| 10.0 / (20_f64.atan() * (1.0 + 400.0 * x * x)),
        cdf: |x| 0.5 + 0.5 * (20.0 * x).atan() / 20_f64.atan(),
        largest: 6.575_322_587_427_171,
        inverse: "tan((2u − 1) atan 20)/20",
    },
];

impl Density {
    /// Fraction of the box around the density that lies below it: what rejection keeps.
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.largest * (self.interval[1] - self.interval[0]))
    }

    /// Edges of `cells` cells of equal length.
    pub fn edges(&self, cells: usize) -> Vec<f64> {
        let [low, high] = self.interval;
        let edge = |i| low + (high - low) * i as f64 / cells as f64;
        (0..=cells).map(edge).collect()
    }
}

/// A discrete distribution.
#[derive(Debug, Clone)]
pub struct Discrete {
    /// What it is.
    pub name: &'static str,
    /// Name of the plot's file.
    pub file: &'static str,
    /// Probabilities; they sum to 1.
    pub probability: Vec<f64>,
}

/// The steps that a sample takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    /// Mean number of steps.
    pub mean: f64,
    /// Mean square of the number of steps.
    pub square: f64,
}

impl Discrete {
    /// The distributions of the experiment.
    pub fn all() -> [Self; 2] {
        let binomial = [1.0, 8.0, 28.0, 56.0, 70.0, 56.0, 28.0, 8.0, 1.0];
        let harmonic: Vec<f64> = (1..=101).map(|k| 1.0 / f64::from(k)).collect();
        [
            Self::new("binomial, 8 coins", "sampling-binomial", &binomial),
            Self::new("∝ 1/k, k = 1 … 101", "sampling-harmonic", &harmonic),
        ]
    }

    fn new(name: &'static str, file: &'static str, weights: &[f64]) -> Self {
        let sum: f64 = weights.iter().sum();
        Self {
            name,
            file,
            probability: weights.iter().map(|w| w / sum).collect(),
        }
    }

    /// The distribution function: the sum up to and with each index.
    pub fn cdf(&self) -> Vec<f64> {
        let sums = self.probability.iter().scan(0.0, |sum, p| {
            *sum += p;
            Some(*sum)
        });
        sums.collect()
    }

    fn largest(&self) -> f64 {
        self.probability.iter().copied().fold(0.0, f64::max)
    }

    /// What `shaders/kernel/lab_discrete.wesl` reads. `scale` multiplies the density that rejection
    /// compares with.
    pub fn table(&self, scale: f64) -> Vec<[u32; 4]> {
        let words = 4_294_967_296.0;
        let alias = AliasTable::new(&self.probability).expect("the probabilities are positive");
        let bits = |p: f64| (p as f32).to_bits();
        let entries = alias.entries.iter().zip(&alias.probability).map(|(e, &p)| {
            let other = alias.probability[e.alias as usize];
            [e.threshold, e.alias, bits(p), bits(other)]
        });
        let largest = self.largest() * scale;
        let parts = self.cdf().into_iter().zip(&self.probability).map(|(f, p)| {
            // Casts saturate at 2³² − 1.
            [(f * words) as u32, (p / largest * words) as u32, 0, 0]
        });
        entries.chain(parts).collect()
    }

    /// Steps of the kernel's `variant`: comparisons of a linear and of a binary search, attempts of
    /// rejection, and the one look-up of an alias table.
    pub fn steps(&self, variant: usize) -> Steps {
        let weighted = |steps: &dyn Fn(usize) -> f64| {
            let terms = self.probability.iter().enumerate();
            let (mean, square) = terms.fold((0.0, 0.0), |(m, s), (i, p)| {
                (m + p * steps(i), s + p * steps(i).powi(2))
            });
            Steps { mean, square }
        };
        let count = self.probability.len();
        match variant {
            0 => weighted(&|i| i as f64 + 1.0),
            1 => weighted(&|i| binary_steps(i, count)),
            2 => {
                let p = 1.0 / (count as f64 * self.largest());
                Steps {
                    mean: 1.0 / p,
                    square: (2.0 - p) / (p * p),
                }
            }
            _ => Steps {
                mean: 1.0,
                square: 1.0,
            },
        }
    }
}

/// Halvings until only `index` of `count` is left.
fn binary_steps(index: usize, count: usize) -> f64 {
    let (mut low, mut high, mut steps) = (0, count - 1, 0.0);
    while low < high {
        let middle = usize::midpoint(low, high);
        if index > middle {
            low = middle + 1;
        } else {
            high = middle;
        }
        steps += 1.0;
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::super::integral;
    use super::*;

    #[test]
    fn distribution_functions_are_integrals_of_the_densities() {
        for d in DENSITIES {
            let [low, high] = d.interval;
            assert!((d.cdf)(low).abs() < 1e-15, "{}", d.name);
            assert!(((d.cdf)(high) - 1.0).abs() < 1e-12, "{}", d.name);
            for i in 1..=8 {
                let x = low + (high - low) * f64::from(i) / 8.0;
                let below = integral(d.pdf, low, x);
                assert!((below - (d.cdf)(x)).abs() < 1e-9, "{} {x}", d.name);
                assert!((d.pdf)(x) <= d.largest * (1.0 + 1e-12), "{}", d.name);
            }
        }
    }

    #[test]
    fn maxima_are_reached() {
        let at = [4.0, 0.0, PI / 4.0, 0.0, 0.0];
        for (d, x) in DENSITIES.iter().zip(at) {
            assert!(((d.pdf)(x) / d.largest - 1.0).abs() < 1e-12, "{}", d.name);
        }
    }

    #[test]
    fn costs_are_those_of_small_cases() {
        let coin = Discrete::new("", "", &[1.0, 1.0, 2.0]);
        // One, two, three comparisons; the binary search takes 2, 2, 1.
        assert!((coin.steps(0).mean - 2.25).abs() < 1e-15);
        assert!((coin.steps(1).mean - 1.5).abs() < 1e-15);
        assert!((coin.steps(2).mean - 1.5).abs() < 1e-15);
        assert!((coin.steps(3).mean - 1.0).abs() < 1e-15);
    }
}
