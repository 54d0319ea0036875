//! Logarithmic axes.

/// From values to pixels, logarithmically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogScale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl LogScale {
    /// A scale on which all positive finite `values` lie, with a little room, from pixel `from` to pixel `to`.
    pub fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.filter(|v| v.is_finite() && *v > 0.0).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let (low, high) = if low <= high {
            (low, high)
        } else {
            (-1.0, 0.0)
        };
        // Half a decade at least, so that nothing is drawn as if it were a difference that is none.
        let room = f64::max(0.04 * (high - low), 0.25 - 0.5 * (high - low)).max(0.02);
        Self {
            low: low - room,
            high: high + room,
            from,
            to,
        }
    }

    /// Pixel of a value; the scale's end for those outside.
    pub fn at(&self, value: f64) -> f64 {
        let log = if value > 0.0 { value.log10() } else { self.low };
        let part = (log.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.from + part * (self.to - self.from)
    }

    /// Exponents of the powers of ten on the scale.
    pub fn decades(&self) -> impl Iterator<Item = i32> + use<> {
        self.low.ceil() as i32..=self.high.floor() as i32
    }

    /// Multiples 2 to 9 of the powers of ten.
    pub fn minor(&self) -> Vec<f64> {
        let (low, high) = (self.low, self.high);
        let decades = low.floor() as i32..=high.floor() as i32;
        let values = decades.flat_map(|d| (2..10).map(move |m| f64::from(m) * 10_f64.powi(d)));
        values
            .filter(|v| (low..=high).contains(&v.log10()))
            .collect()
    }

    /// Whether powers of ten are too few to read values by.
    pub fn is_short(&self) -> bool {
        self.decades().count() < 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_inside_in_order() {
        let scale = LogScale::over([0.02, 5.0, 0.0, f64::NAN].into_iter(), 100.0, 500.0);
        let (a, b) = (scale.at(0.02), scale.at(5.0));
        assert!(100.0 < a && a < b && b < 500.0);
        assert!((scale.at(0.0) - 100.0).abs() < 1e-9);
        assert_eq!(scale.decades().collect::<Vec<_>>(), [-1, 0]);
        assert!(scale.minor().contains(&2.0));
    }

    #[test]
    fn a_single_value_has_a_scale() {
        let scale = LogScale::over([3.0].into_iter(), 0.0, 1.0);
        assert!((scale.at(3.0) - 0.5).abs() < 1e-9);
        assert!(
            LogScale::over(std::iter::empty(), 0.0, 1.0)
                .at(1.0)
                .is_finite()
        );
    }
}
