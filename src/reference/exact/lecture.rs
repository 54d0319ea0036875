//! Importance sampling of ∫₀⁴ x dx = 8 with linear densities, the lecture's table.

/// The integral of x over [0, 4].
pub const INTEGRAL: f64 = 8.0;

/// The density p(x) = `constant` + `slope`·x on [0, 4]: not negative, its integral 4·constant +
/// 8·slope = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearDensity {
    /// p(0).
    pub constant: f64,
    /// dp/dx.
    pub slope: f64,
}

impl LinearDensity {
    /// Variance of the estimator x/p(x) of one sample: ∫₀⁴ x²/p(x) dx − 64.
    pub fn variance(&self) -> f64 {
        let Self {
            constant: a,
            slope: b,
        } = *self;
        let second_moment = if b.abs() <= 0.0 {
            64.0 / (3.0 * a)
        } else if a <= 0.0 {
            8.0 / b
        } else {
            // The antiderivative of x²/(a + bx) is x²/(2b) − ax/b² + (a²/b³) ln(a + bx).
            8.0 / b - 4.0 * a / (b * b) + (a * a / (b * b * b)) * (4.0 * b / a).ln_1p()
        };
        second_moment - INTEGRAL * INTEGRAL
    }

    /// Number of samples, not rounded, whose mean has this standard deviation.
    pub fn samples_for(&self, standard_deviation: f64) -> f64 {
        self.variance() / (standard_deviation * standard_deviation)
    }
}
