//! From values to pixels.

use super::text::superscript;

/// Numbers of a logarithmic scale at most, one for each power of ten or for each second, third, …
/// one.
const MAX_POWERS: i32 = 10;
/// Numbers of a linear scale at most.
const MAX_STEPS: f64 = 6.0;

/// A line of a plot's grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Its pixel.
    pub at: f64,
    /// Its number; empty where there is none.
    pub label: String,
    /// Whether it lies between those that one reads values by.
    pub minor: bool,
}

impl Tick {
    /// Class of the line.
    pub fn class(&self) -> &'static str {
        if self.minor { "minor" } else { "grid" }
    }
}

/// From values to pixels, linearly or logarithmically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Values at the ends; on a logarithmic scale their logarithms.
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    logarithmic: bool,
}

impl Scale {
    /// A logarithmic scale on which all positive finite `values` lie, with a little room, from the
    /// first of `pixels` to the second.
    pub fn logarithmic(values: impl Iterator<Item = f64>, pixels: (f64, f64)) -> Self {
        let logs = values.filter(|v| v.is_finite() && *v > 0.0).map(f64::log10);
        let (low, high) = range(logs).unwrap_or((-1.0, 0.0));
        // Half a decade at least, so that nothing is drawn as if it were a difference that is none.
        let room = f64::max(0.04 * (high - low), 0.25 - 0.5 * (high - low)).max(0.02);
        Self {
            low: low - room,
            high: high + room,
            from: pixels.0,
            to: pixels.1,
            logarithmic: true,
        }
    }

    /// A linear scale from the least to the greatest of the finite `values`.
    pub fn linear(values: impl Iterator<Item = f64>, pixels: (f64, f64)) -> Self {
        let (low, high) = range(values.filter(|v| v.is_finite())).unwrap_or((0.0, 1.0));
        let room = if high > low { 0.0 } else { 0.5 };
        Self {
            low: low - room,
            high: high + room,
            from: pixels.0,
            to: pixels.1,
            logarithmic: false,
        }
    }

    /// Pixel of a value; the scale's end for those outside.
    pub fn at(&self, value: f64) -> f64 {
        let position = match (self.logarithmic, value > 0.0) {
            (true, true) => value.log10(),
            (true, false) => self.low,
            (false, _) => value,
        };
        let part = (position.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.from + part * (self.to - self.from)
    }

    /// Whether a value lies on it.
    pub fn holds(&self, value: f64) -> bool {
        let position = if self.logarithmic {
            value.log10()
        } else {
            value
        };
        (self.low..=self.high).contains(&position)
    }

    /// The lines of its grid, those between the others first.
    pub fn ticks(&self) -> Vec<Tick> {
        if self.logarithmic {
            self.powers()
        } else {
            self.steps()
        }
    }

    /// Powers of ten, and their multiples 2 to 9, of which 2 and 5 have numbers where powers alone
    /// are too few to read values by.
    fn powers(&self) -> Vec<Tick> {
        let powers = self.low.ceil() as i32..=self.high.floor() as i32;
        let count = powers.clone().count() as i32;
        let step = (count + MAX_POWERS - 1) / MAX_POWERS;
        let mut ticks = Vec::new();
        for power in self.low.floor() as i32..=self.high.floor() as i32 {
            let multiples = (2..10).map(|m| (m, f64::from(m) * 10_f64.powi(power)));
            let inside = multiples.filter(|(_, v)| (self.low..=self.high).contains(&v.log10()));
            ticks.extend(inside.filter(|_| step < 2).map(|(m, v)| Tick {
                at: self.at(v),
                // The others are too close for numbers.
                label: if count < 2 && (m == 2 || m == 5) {
                    super::text::number(v)
                } else {
                    String::new()
                },
                minor: true,
            }));
        }
        ticks.extend(powers.filter(|p| step < 2 || p % step == 0).map(|p| Tick {
            at: self.at(10_f64.powi(p)),
            label: format!("10{}", superscript(p)),
            minor: false,
        }));
        ticks
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn steps(&self) -> Vec<Tick> {
        let raw = (self.high - self.low) / MAX_STEPS;
        let power = 10_f64.powf(raw.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
        let step = steps.into_iter().find(|&s| s >= raw).unwrap_or(raw);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        let tick = |i: i64| {
            let value = i as f64 * step;
            Tick {
                at: self.at(value),
                label: format!("{value:.decimals$}").replace('-', "−"),
                minor: false,
            }
        };
        (first..=last).map(tick).collect()
    }
}

/// The least and the greatest of `values`.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.fold(ends, |(low, high), x| (low.min(x), high.max(x)));
    (low <= high).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale, minor: bool) -> Vec<String> {
        let ticks = scale.ticks().into_iter();
        let ticks = ticks.filter(|t| t.minor == minor && !t.label.is_empty());
        ticks.map(|t| t.label).collect()
    }

    #[test]
    fn values_lie_inside_in_order() {
        let values = [0.02, 5.0, 0.0, f64::NAN].into_iter();
        let scale = Scale::logarithmic(values, (100.0, 500.0));
        let (a, b) = (scale.at(0.02), scale.at(5.0));
        assert!(100.0 < a && a < b && b < 500.0);
        assert!((scale.at(0.0) - 100.0).abs() < 1e-9);
        assert_eq!(labels(&scale, false), ["10⁻¹", "10⁰"]);
        assert_eq!(labels(&scale, true), [""; 0]);
        let at = scale.at(2.0);
        assert!(
            scale
                .ticks()
                .iter()
                .any(|t| t.minor && (t.at - at).abs() < 1e-9)
        );
    }

    #[test]
    fn a_single_value_has_a_scale() {
        let scale = Scale::logarithmic([3.0].into_iter(), (0.0, 1.0));
        assert!((scale.at(3.0) - 0.5).abs() < 1e-9);
        assert_eq!(
            labels(&scale, true),
            ["2.00", "5.00"],
            "3, 4 and the rest are too close"
        );
        let linear = Scale::linear([3.0].into_iter(), (0.0, 1.0));
        assert!((linear.at(3.0) - 0.5).abs() < 1e-9);
        for empty in [Scale::logarithmic, Scale::linear] {
            assert!(empty(std::iter::empty(), (0.0, 1.0)).at(1.0).is_finite());
        }
    }

    #[test]
    fn many_decades_have_few_numbers() {
        let scale = Scale::logarithmic([1e-16, 1.0].into_iter(), (0.0, 1.0));
        let found = labels(&scale, false);
        assert_eq!(found.first().map(String::as_str), Some("10⁻¹⁶"));
        assert_eq!(found.len(), 9);
    }

    #[test]
    fn linear_scales_count_by_round_numbers() {
        let scale = Scale::linear([-1.0, 1.0].into_iter(), (0.0, 100.0));
        assert_eq!(labels(&scale, false), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert!((scale.at(0.5) - 75.0).abs() < 1e-9);
        let scale = Scale::linear([0.0, 30.0].into_iter(), (0.0, 100.0));
        assert_eq!(
            labels(&scale, false),
            ["0", "5", "10", "15", "20", "25", "30"]
        );
    }
}
