//! Levels for families of tests.

use statrs::function::erf::erfc_inv;
use std::f64::consts::SQRT_2;

/// Probability that a whole family of tests raises any false alarm.
pub const FAMILY_LEVEL: f64 = 1e-4;

/// Tests of which none may fail. The levels hold exactly when they are independent, and from above
/// for two-sided normal tests however dependent (Šidák 1967).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// Probability that any of the tests rejects although all null hypotheses hold; in (0, 1).
    pub level: f64,
    /// Number of tests, at least 1.
    pub tests: usize,
}

impl Family {
    /// A family of `tests` tests at [`FAMILY_LEVEL`].
    pub fn new(tests: usize) -> Self {
        Self {
            level: FAMILY_LEVEL,
            tests,
        }
    }

    /// The level of each test, 1 − (1 − level)^(1/tests), without cancellation.
    pub fn test_level(&self) -> f64 {
        assert!(self.tests > 0, "a family has at least one test");
        -((-self.level).ln_1p() / self.tests as f64).exp_m1()
    }

    /// Whether a test of the family with this p-value rejects. Something that is not a number
    /// rejects.
    pub fn rejects(&self, p_value: f64) -> bool {
        p_value.is_nan() || p_value < self.test_level()
    }

    /// The |z| from which on a two-sided normal test of the family rejects.
    pub fn z_bound(&self) -> f64 {
        SQRT_2 * erfc_inv(self.test_level())
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{EXPERIMENTS, Stream};
    use super::super::two_sided_normal;
    use super::*;

    #[test]
    fn levels_compose_to_the_family_level() {
        for tests in [1_usize, 2, 10, 1000, 1_000_000_000] {
            let family = Family::new(tests);
            let any = -(tests as f64 * (-family.test_level()).ln_1p()).exp_m1();
            assert!((any / FAMILY_LEVEL - 1.0).abs() < 1e-12, "{tests}");
        }
        let two = Family {
            level: 0.19,
            tests: 2,
        };
        assert!((two.test_level() - 0.1).abs() < 1e-15);
    }

    #[test]
    fn the_bound_is_where_a_normal_test_rejects() {
        for tests in [1, 7, 12_345] {
            let family = Family::new(tests);
            let p = two_sided_normal(family.z_bound());
            assert!((p / family.test_level() - 1.0).abs() < 1e-9, "{tests}");
        }
        // Φ⁻¹(1 − 0.5e-4) (Abramowitz & Stegun, table 26.6).
        assert!((Family::new(1).z_bound() - 3.890_591_886_413_12).abs() < 1e-9);
    }

    #[test]
    fn the_level_itself_does_not_reject() {
        let family = Family::new(3);
        assert!(!family.rejects(family.test_level()) && !family.rejects(1.0));
        assert!(family.rejects(0.99 * family.test_level()) && family.rejects(f64::NAN));
    }

    #[test]
    fn a_family_rejects_at_its_level() {
        // 5 % of 20,000: 1000 with standard deviation 30.8, at the level of
        // `assert_rejects_at_its_rate`.
        let family = Family {
            level: 0.05,
            tests: 20,
        };
        let mut stream = Stream::new(7);
        let alarms = (0..EXPERIMENTS)
            .filter(|_| (0..20).filter(|_| family.rejects(stream.uniform())).count() > 0)
            .count();
        assert!(
            (alarms as f64 - 1000.0).abs() < Family::new(10).z_bound() * 30.8,
            "{alarms}"
        );
    }
}
