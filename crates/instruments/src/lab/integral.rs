//! One integral by one method with one number of points, on the GPU: what
//! [`quadrature`](super::quadrature) is made of.

use super::Settings;
use super::bench::Bench;
use super::layout::LabRun;
use super::rules::{Integrand, Rule, corner, r_sequence};
use direkt::error::GpuError;
use direkt::low_level::stats::moments::Moments;

/// Most dimensions.
pub const DIMENSIONS: u32 = 6;
/// Points that an invocation sums in f32.
const RUN: u32 = 16;
/// Boxes that a rule is tried on; a smooth integrand has but one integral.
const BOXES: u32 = 64;
/// Replicates of random points, each with its own box.
const REPLICATES: u32 = 128;
/// Numbers of random points.
const POINTS: [u32; 4] = [64, 256, 1024, 4096];
/// Panels per axis that rules are tried with.
const PANELS: [u32; 19] = [
    1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 1024,
];

/// Where points come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// A tensor product of a rule.
    Rule(Rule),
    /// Independent random points.
    Independent,
    /// Pairs of scrambled Sobol dimensions.
    Sobol,
    /// Roberts's sequence, randomly shifted.
    RSequence,
}

impl Method {
    /// In the order of the shader's numbers.
    pub const ALL: [Self; 7] = [
        Self::Rule(Rule::Midpoint),
        Self::Rule(Rule::Trapezoid),
        Self::Rule(Rule::Simpson),
        Self::Rule(Rule::Gauss),
        Self::Independent,
        Self::Sobol,
        Self::RSequence,
    ];

    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rule(rule) => rule.name(),
            Self::Independent => "Monte Carlo",
            Self::Sobol => "Sobol pairs",
            Self::RSequence => "R sequence",
        }
    }

    /// The exponent of n that theory gives the error.
    pub fn theory(self, integrand: Integrand, dimensions: u32) -> f64 {
        let s = f64::from(dimensions);
        match (self, integrand) {
            (Self::Rule(rule), Integrand::Smooth) => -rule.order() / s,
            (Self::Rule(_), Integrand::Box) => -1.0 / s,
            (Self::Independent, _) => -0.5,
            (Self::Sobol, _) if dimensions > 2 => -0.5,
            (Self::Sobol, Integrand::Smooth) => -1.5,
            (Self::Sobol | Self::RSequence, _) => -1.0,
        }
    }
}

/// One integral with one number of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// What is integrated.
    pub integrand: Integrand,
    /// How.
    pub method: Method,
    /// In how many dimensions.
    pub dimensions: u32,
    /// Panels along an axis of a rule, else the number of points.
    pub size: u32,
}

impl Case {
    /// Evaluations of the integrand; `None` where 32 bits do not hold them.
    pub fn evaluations(&self) -> Option<u32> {
        match self.method {
            Method::Rule(rule) => rule.nodes(self.size).checked_pow(self.dimensions),
            _ => Some(self.size),
        }
    }

    /// n of the theory: panels, or points.
    pub fn n(&self) -> f64 {
        match self.method {
            Method::Rule(_) => f64::from(self.size).powi(self.dimensions as i32),
            _ => f64::from(self.size),
        }
    }

    /// Integrals, each of a box of its own.
    pub fn replicates(&self) -> u32 {
        match (self.method, self.integrand) {
            (Method::Rule(_), Integrand::Smooth) => 1,
            (Method::Rule(_), Integrand::Box) => BOXES,
            _ => REPLICATES,
        }
    }

    /// The corner of replicate `index`'s box, in as many dimensions as the case has.
    pub fn corner(&self, seed: u32, index: u32) -> Vec<f64> {
        corner(seed, index)[..self.dimensions as usize].to_vec()
    }

    /// What f32 may add, relative to a sum of positive terms: 16 additions, and per term an
    /// exponential (WGSL grants 3 + 2|x| ulp), coordinates, weights and constants. Half of
    /// `f32::EPSILON` is one rounding.
    pub fn allowance(&self) -> f64 {
        (21.0 + 16.0 * f64::from(self.dimensions)) * 0.5 * f64::from(f32::EPSILON)
    }

    fn stream(&self) -> u32 {
        let log = self.size.ilog2();
        (self.variant() * 8 + self.dimensions) * 32 + log
    }

    /// Number of the integrand and the method in the kernel.
    pub fn variant(&self) -> u32 {
        let at = Method::ALL.iter().position(|m| *m == self.method);
        let method = at.expect("ALL has all methods") as u32;
        8 * u32::from(self.integrand == Integrand::Box) + method
    }

    /// The case's integrals on the GPU, one per replicate.
    ///
    /// # Errors
    /// The driver fails.
    pub fn integrals(&self, bench: &Bench<'_>, settings: &Settings) -> Result<Vec<f64>, GpuError> {
        let points = self.evaluations().expect("cases are chosen to be small");
        let runs = points.div_ceil(RUN);
        let run = LabRun {
            variant: self.variant(),
            items: runs * self.replicates(),
            samples: RUN,
            seed: settings.seed,
            stream: self.stream(),
            size: self.size,
            dimensions: self.dimensions,
            constants: [(1.0 / settings.density_scale) as f32, 0.0, 0.0, 0.0],
            ..LabRun::default()
        };
        let blocks = bench.run(&run, &self.table(settings.seed))?.blocks;
        let replicates = blocks.chunks_exact(runs as usize);
        Ok(replicates
            .map(super::layout::merged)
            .map(|m| m.mean)
            .collect())
    }

    /// Steps of the R sequence, then the boxes; axes that the integrand does not have are 1.
    fn table(&self, seed: u32) -> Vec<[u32; 4]> {
        let step = r_sequence(self.dimensions);
        let mut table = vec![
            [step[0], step[1], step[2], step[3]],
            [step[4], step[5], step[6], step[7]],
        ];
        for index in 0..self.replicates() {
            let own = self.corner(seed, index);
            let bits = |i: usize| (own.get(i).copied().unwrap_or(1.0) as f32).to_bits();
            table.push([0, 1, 2, 3].map(bits));
            table.push([4, 5, 6, 7].map(bits));
        }
        table
    }
}

/// A measured case.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Which.
    pub case: Case,
    /// Per replicate, GPU minus the exact integral.
    pub errors: Vec<f64>,
    /// Per replicate, the standard deviation of one random point.
    pub deviations: Vec<f64>,
    /// Largest difference to what the rule gives in f64; 0 for random points.
    pub off: f64,
}

impl Measured {
    /// Runs `case`.
    ///
    /// # Errors
    /// The driver fails.
    pub fn new(bench: &Bench<'_>, settings: &Settings, case: Case) -> Result<Self, GpuError> {
        let integrals = case.integrals(bench, settings)?;
        let mut measured = Self {
            case,
            errors: Vec::new(),
            deviations: Vec::new(),
            off: 0.0,
        };
        for (found, index) in integrals.into_iter().zip(0..) {
            let corner = case.corner(settings.seed, index);
            measured
                .errors
                .push(found - case.integrand.integral(&corner));
            let variance = case.integrand.variance_and_kurtosis(&corner).0;
            measured.deviations.push(variance.sqrt());
            if let Method::Rule(rule) = case.method {
                let due = case.integrand.by_rule(rule, case.size, &corner);
                measured.off = measured.off.max((found - due).abs());
            }
        }
        Ok(measured)
    }

    /// Root mean squared error.
    pub fn rms(&self) -> f64 {
        let squares: Moments = self.errors.iter().map(|e| e * e).collect();
        squares.mean.sqrt()
    }

    /// Root mean square of the errors over the deviation of one point: 1/√n for independent points.
    pub fn normalised_rms(&self) -> f64 {
        let pairs = self.errors.iter().zip(&self.deviations);
        let squares: Moments = pairs.map(|(e, d)| (e / d).powi(2)).collect();
        squares.mean.sqrt()
    }
}

/// The cases whose slope is measured: those that are affordable and whose error is above rounding;
/// of a smooth integrand the four largest, because the theory's power is that of the limit.
pub fn ladder(integrand: Integrand, method: Method, dimensions: u32) -> Vec<Case> {
    let case = |size| Case {
        integrand,
        method,
        dimensions,
        size,
    };
    let Method::Rule(rule) = method else {
        return POINTS.map(case).to_vec();
    };
    let most = match integrand {
        Integrand::Smooth => 1 << 18,
        Integrand::Box => 1 << 16,
    };
    let mut cases: Vec<Case> = PANELS.map(case).to_vec();
    cases.retain(|c| {
        let error = match integrand {
            Integrand::Smooth => (rule.of_smooth(c.size).powi(dimensions as i32) - 1.0).abs(),
            Integrand::Box => 1.0,
        };
        let fits = c.evaluations().is_some_and(|n| n <= most);
        fits && error > 20.0 * c.allowance()
    });
    // One panel is far from what the theory is about; in six dimensions there may be little else.
    if cases.len() > 2 && cases[0].size == 1 {
        cases.remove(0);
    }
    match integrand {
        Integrand::Smooth => cases.split_off(cases.len().saturating_sub(4)),
        Integrand::Box => cases,
    }
}

#[cfg(test)]
mod tests {
    use super::super::slope;
    use super::*;

    #[test]
    fn every_ladder_has_a_slope() {
        for integrand in Integrand::ALL {
            for method in Method::ALL {
                for s in 1..=DIMENSIONS {
                    let cases = ladder(integrand, method, s);
                    assert!(cases.len() >= 2, "{integrand:?} {method:?} {s}");
                    assert!(cases.windows(2).all(|w| w[0].n() < w[1].n()));
                }
            }
        }
    }

    #[test]
    fn closed_forms_have_the_orders_of_the_theory() {
        for rule in Rule::ALL {
            for s in 1..=4 {
                let cases = ladder(Integrand::Smooth, Method::Rule(rule), s);
                let points: Vec<(f64, f64)> = cases
                    .iter()
                    .map(|c| (c.n(), (rule.of_smooth(c.size).powi(s as i32) - 1.0).abs()))
                    .collect();
                let theory = Method::Rule(rule).theory(Integrand::Smooth, s);
                let found = slope(&points);
                // The next term of the error is a relative t²/10 or less, t = 1/2 at most, and s²
                // times so in s dimensions.
                assert!((found / theory - 1.0).abs() < 0.1, "{rule:?} {s}: {found}");
            }
        }
    }
}
