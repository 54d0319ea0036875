//! The symmetric test for pairs that come one at a time.

use super::symmetric::Symmetric;

/// Sum and sum of squares of differences.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairSum {
    /// Number of pairs.
    pub pairs: u64,
    /// Σ d.
    pub sum: f64,
    /// Σ d².
    pub squares: f64,
}

impl PairSum {
    /// Adds the difference of a pair.
    pub fn add(&mut self, difference: f64) {
        self.pairs += 1;
        self.sum += difference;
        self.squares += difference * difference;
    }

    /// Adds all pairs of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// The test of [`symmetric_test`](super::symmetric::symmetric_test), where the mean difference
    /// may be off by `allowance` for another reason, such as rounding. A sum that is not finite
    /// gives p-value 0.
    pub fn test(&self, allowance: f64) -> Symmetric {
        let excess = (self.sum.abs() - self.pairs as f64 * allowance).max(0.0);
        let t = if self.squares > 0.0 {
            (excess / self.squares.sqrt()).copysign(self.sum)
        } else {
            0.0
        };
        let finite = self.sum.is_finite() && self.squares.is_finite();
        Symmetric {
            t: if finite { t } else { f64::NAN },
            pairs: self.pairs as usize,
            p_value: if finite {
                (2.0 * (-0.5 * t * t).exp()).min(1.0)
            } else {
                0.0
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::symmetric::symmetric_test;
    use super::*;

    fn sum_of(differences: &[f64]) -> PairSum {
        let mut sum = PairSum::default();
        differences.iter().for_each(|d| sum.add(*d));
        sum
    }

    #[test]
    fn it_is_the_test_of_all_differences_at_once() {
        let differences = [0.5, -1.25, 3.0, 0.0, 2.0, -0.75];
        let (first, second) = differences.split_at(2);
        let mut merged = sum_of(first);
        merged.merge(&sum_of(second));
        let (by_sum, at_once) = (merged.test(0.0), symmetric_test(&differences));
        assert!((by_sum.t - at_once.t).abs() < 1e-15);
        assert!((by_sum.p_value - at_once.p_value).abs() < 1e-15);
        assert_eq!(by_sum.pairs, at_once.pairs);
    }

    #[test]
    fn an_allowance_explains_what_is_within_it() {
        let sum = sum_of(&[1e-6; 100]);
        assert!(sum.test(0.0).p_value < 1e-20);
        assert!(sum.test(2e-6).p_value >= 1.0);
        assert!((sum_of(&[-1.0; 9]).test(0.0).t + 3.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_number_is_rejected() {
        assert!(sum_of(&[1.0, f64::NAN]).test(1.0).p_value <= 0.0);
        assert!(sum_of(&[f64::INFINITY]).test(1.0).p_value <= 0.0);
    }
}
