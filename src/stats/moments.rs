//! Mean and variance in one pass.

/// Number, mean and spread of the values so far (Welford 1962).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    /// Number of values.
    pub count: u64,
    /// Their mean; 0 when there are none.
    pub mean: f64,
    /// Sum of squared deviations from the mean.
    pub m2: f64,
}

impl Moments {
    /// Adds one value.
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let delta = value - self.mean;
        self.mean += delta / self.count as f64;
        self.m2 += delta * (value - self.mean);
    }

    /// Adds the values that `other` was made of (Chan, Golub & LeVeque 1979).
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (na, nb) = (self.count as f64, other.count as f64);
        let n = na + nb;
        let delta = other.mean - self.mean;
        self.mean += delta * (nb / n);
        self.m2 += other.m2 + delta * delta * (na * nb / n);
        self.count += other.count;
    }

    /// Unbiased variance of one value; `None` below two values.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.m2 / (self.count as f64 - 1.0))
    }

    /// Variance of the mean; `None` below two values.
    pub fn variance_of_mean(&self) -> Option<f64> {
        let n = self.count as f64;
        (self.count > 1).then(|| self.m2 / (n * (n - 1.0)))
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.push(value);
        }
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Stream;
    use super::*;

    #[test]
    fn merging_equals_pushing() {
        let mut stream = Stream::new(0);
        let values: Vec<f64> = (0..1000).map(|_| 100.0 + stream.normal()).collect();
        let all: Moments = values.iter().copied().collect();
        let mut merged = Moments::default();
        for chunk in values.chunks(77) {
            merged.merge(&chunk.iter().copied().collect());
        }
        let mean = values.iter().sum::<f64>() / 1000.0;
        let m2: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        for moments in [all, merged] {
            assert_eq!(moments.count, 1000);
            assert!((moments.mean - mean).abs() < 1e-12 * mean);
            assert!((moments.m2 - m2).abs() < 1e-11 * m2);
        }
    }

    #[test]
    fn variances_are_unbiased_and_need_two_values() {
        let two: Moments = [1.0, 3.0].into_iter().collect();
        assert!((two.variance().unwrap() - 2.0).abs() < f64::EPSILON);
        assert!((two.variance_of_mean().unwrap() - 1.0).abs() < f64::EPSILON);
        let one: Moments = [1.0].into_iter().collect();
        assert!(one.variance().is_none() && one.variance_of_mean().is_none());
    }

    #[test]
    fn merging_with_nothing_changes_nothing() {
        let values: Moments = [1.0, 2.0, 4.0].into_iter().collect();
        let mut left = values;
        left.merge(&Moments::default());
        let mut right = Moments::default();
        right.merge(&values);
        assert_eq!(left, values);
        assert_eq!(right, values);
    }
}
