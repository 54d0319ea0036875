//! Quadrature in f64: the rules of `shaders/lab/rules.wesl`, closed forms of what they give, and
//! the integrands.
//!
//! On [0, 1] with n panels and g(x) = 2e^(2x)/(e² − 1), whose integral is 1, every rule is a
//! geometric series; with t = 1/n:
//!
//! ```text
//!     midpoint M = t/sinh t          I − M = (b−a)³f″/(24n²) − …
//!     trapezoid T = t/tanh t         I − T = −(b−a)³f″/(12n²) + …
//!     Simpson (2M + T)/3             order n⁻⁴
//!     Gauss–Legendre, two points per panel: t·cosh(t/√3)/sinh t, order n⁻⁴
//! ```

use direkt::low_level::reference::core::rng::pcg4d;

/// A quadrature rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The middle of each panel.
    Midpoint,
    /// Both ends.
    Trapezoid,
    /// Ends and middle.
    Simpson,
    /// Gauss and Legendre's two points.
    Gauss,
}

impl Rule {
    /// In the order of the shader's numbers.
    pub const ALL: [Self; 4] = [Self::Midpoint, Self::Trapezoid, Self::Simpson, Self::Gauss];

    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Midpoint => "midpoint",
            Self::Trapezoid => "trapezoid",
            Self::Simpson => "Simpson",
            Self::Gauss => "Gauss, 2 points",
        }
    }

    /// r: the error of a smooth integrand falls with the panels along an axis as m^−r.
    pub fn order(self) -> f64 {
        match self {
            Self::Midpoint | Self::Trapezoid => 2.0,
            Self::Simpson | Self::Gauss => 4.0,
        }
    }

    /// Number of nodes along an axis.
    pub fn nodes(self, panels: u32) -> u32 {
        match self {
            Self::Midpoint => panels,
            Self::Trapezoid => panels + 1,
            Self::Simpson => 2 * panels + 1,
            Self::Gauss => 2 * panels,
        }
    }

    /// Nodes and weights; the weights sum to 1.
    pub fn points(self, panels: u32) -> Vec<(f64, f64)> {
        let (m, count) = (f64::from(panels), self.nodes(panels));
        let end = |i| i == 0 || i + 1 == count;
        let point = |i: u32| {
            let at = f64::from(i);
            match self {
                Self::Midpoint => ((at + 0.5) / m, 1.0 / m),
                Self::Trapezoid => (at / m, if end(i) { 0.5 } else { 1.0 } / m),
                Self::Simpson => {
                    let inner = if i % 2 == 1 { 4.0 } else { 2.0 };
                    (at / (2.0 * m), if end(i) { 1.0 } else { inner } / (6.0 * m))
                }
                Self::Gauss => {
                    let side = if i % 2 == 1 { 0.5 } else { -0.5 };
                    let middle = f64::from(i / 2) + 0.5;
                    ((middle + side / 3_f64.sqrt()) / m, 0.5 / m)
                }
            }
        };
        (0..count).map(point).collect()
    }

    /// The rule's integral of g, see the module.
    pub fn of_smooth(self, panels: u32) -> f64 {
        let t = 1.0 / f64::from(panels);
        match self {
            Self::Midpoint => t / t.sinh(),
            Self::Trapezoid => t / t.tanh(),
            Self::Simpson => (2.0 * t / t.sinh() + t / t.tanh()) / 3.0,
            Self::Gauss => t * (t / 3_f64.sqrt()).cosh() / t.sinh(),
        }
    }

    /// The rule's integral of the step that is 1 below `c`, else 0.
    pub fn of_step(self, panels: u32, c: f64) -> f64 {
        let below = self.points(panels).into_iter().filter(|p| p.0 < c);
        below.map(|p| p.1).sum()
    }
}

/// What is integrated over the unit cube of some dimension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrand {
    /// ∏ g(x_i): the integral is 1.
    Smooth,
    /// 1 in the box between the origin and a corner c, else 0: the integral is ∏ c_i.
    Box,
}

impl Integrand {
    /// In the order of the shader's numbers.
    pub const ALL: [Self; 2] = [Self::Smooth, Self::Box];

    /// The integral, for the corner `corner` in as many dimensions.
    pub fn integral(self, corner: &[f64]) -> f64 {
        match self {
            Self::Smooth => 1.0,
            Self::Box => corner.iter().product(),
        }
    }

    /// What `rule` gives for it.
    pub fn by_rule(self, rule: Rule, panels: u32, corner: &[f64]) -> f64 {
        match self {
            Self::Smooth => rule.of_smooth(panels).powi(corner.len() as i32),
            Self::Box => corner.iter().map(|&c| rule.of_step(panels, c)).product(),
        }
    }

    /// Variance of one random point, and its kurtosis.
    pub fn variance_and_kurtosis(self, corner: &[f64]) -> (f64, f64) {
        match self {
            Self::Smooth => {
                // E g^k = (2/(e² − 1))^k (e^(2k) − 1)/(2k).
                let factor = 2.0 / 2_f64.exp_m1();
                let moment = |k: i32| {
                    let one = factor.powi(k) * f64::from(2 * k).exp_m1() / f64::from(2 * k);
                    one.powi(corner.len() as i32)
                };
                let variance = moment(2) - 1.0;
                let fourth = moment(4) - 4.0 * moment(3) + 6.0 * moment(2) - 3.0;
                (variance, fourth / (variance * variance))
            }
            Self::Box => {
                let p = self.integral(corner);
                let variance = p * (1.0 - p);
                (variance, (1.0 - 3.0 * variance) / variance)
            }
        }
    }
}

/// Corner number `index` in six dimensions: odd multiples of 2⁻¹⁹ in [½, 1), which f32 holds and no
/// rule's nodes meet.
pub fn corner(seed: u32, index: u32) -> [f64; 6] {
    let words = [0, 1].map(|half| pcg4d([index, half, 0xb0c5, seed]));
    std::array::from_fn(|i| {
        let word = words[i / 4][i % 4] >> 15;
        (131_072.0 + f64::from(word) + 0.5) / 262_144.0
    })
}

/// The R sequence's steps in `dimensions` dimensions, in units of 2⁻³² (Roberts 2018, "The
/// Unreasonable Effectiveness of Quasirandom Sequences"): powers of 1/φ with φ^(s+1) = φ + 1. In
/// one dimension φ is the golden ratio.
pub fn r_sequence(dimensions: u32) -> [u32; 8] {
    let mut phi: f64 = 2.0;
    for _ in 0..64 {
        phi = (1.0 + phi).powf(1.0 / (f64::from(dimensions) + 1.0));
    }
    std::array::from_fn(|i| (phi.powi(-(i as i32 + 1)) * 4_294_967_296.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn g(x: f64) -> f64 {
        2.0 * (2.0 * x).exp() / 2_f64.exp_m1()
    }

    #[test]
    fn closed_forms_are_the_sums() {
        for rule in Rule::ALL {
            for panels in [1, 2, 3, 8, 33] {
                let points = rule.points(panels);
                assert_eq!(points.len(), rule.nodes(panels) as usize);
                let weights: f64 = points.iter().map(|p| p.1).sum();
                assert!((weights - 1.0).abs() < 1e-14, "{rule:?} {panels}");
                let sum: f64 = points.iter().map(|p| p.1 * g(p.0)).sum();
                let closed = rule.of_smooth(panels);
                assert!((sum - closed).abs() < 1e-14, "{rule:?} {panels}");
            }
        }
    }

    #[test]
    fn errors_approach_the_lectures_formulas() {
        // f″ averages f′(1) − f′(0) = 4.
        for n in [64_u32, 256] {
            let square = f64::from(n * n);
            let midpoint = 1.0 - Rule::Midpoint.of_smooth(n);
            let trapezoid = 1.0 - Rule::Trapezoid.of_smooth(n);
            assert!((midpoint / (4.0 / 24.0 / square) - 1.0).abs() < 1e-4);
            assert!((trapezoid / (-4.0 / 12.0 / square) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn moments_are_the_sums() {
        let fine = Rule::Gauss.points(2000);
        let mean = |f: &dyn Fn(f64) -> f64| -> f64 { fine.iter().map(|p| p.1 * f(p.0)).sum() };
        let (variance, kurtosis) = Integrand::Smooth.variance_and_kurtosis(&[0.5]);
        let expected = mean(&|x| (g(x) - 1.0).powi(2));
        assert!((variance - expected).abs() < 1e-10);
        let fourth = mean(&|x| (g(x) - 1.0).powi(4));
        assert!((kurtosis - fourth / (expected * expected)).abs() < 1e-9);
        let (variance, kurtosis) = Integrand::Box.variance_and_kurtosis(&[0.5]);
        assert!((variance - 0.25).abs() < 1e-15 && (kurtosis - 1.0).abs() < 1e-12);
    }

    #[test]
    fn corners_are_numbers_of_f32_off_all_nodes() {
        for index in 0..200 {
            for c in corner(7, index) {
                assert!((0.5..1.0).contains(&c));
                assert!((f64::from(c as f32) - c).abs() <= 0.0);
                let halves = c * 262_144.0;
                assert!((halves.fract() - 0.5).abs() <= 0.0);
            }
        }
    }

    #[test]
    fn the_r_sequence_begins_with_the_golden_ratio() {
        let golden = 0.618_033_988_749_894_9 * 4_294_967_296.0;
        assert!((f64::from(r_sequence(1)[0]) - golden).abs() < 2.0);
        let plastic = 0.754_877_666_246_692_8 * 4_294_967_296.0;
        assert!((f64::from(r_sequence(2)[0]) - plastic).abs() < 2.0);
    }
}
