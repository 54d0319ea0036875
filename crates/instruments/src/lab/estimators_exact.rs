//! Exact means and variances of [`estimators`](super::estimators).
//!
//! For positive sums A and B of n independent pairs (a, b), ratios have the moments (Laplace)
//!
//! ```text
//!     E[A/B]     = ∫₀^∞ E[A e^(−tB)] dt     = n ∫ E[a e^(−tb)] ψⁿ⁻¹ dt,           ψ(t) = E[e^(−tb)]
//!     E[(A/B)²]  = ∫₀^∞ t E[A² e^(−tB)] dt  = ∫ t (n E[a² e^(−tb)] ψⁿ⁻¹ + n(n−1) E[a e^(−tb)]² ψⁿ⁻²) dt
//! ```

use super::rules::Rule;
use direkt::low_level::reference::exact::lecture::LinearDensity;

/// Mean and variance of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments2 {
    /// Its mean.
    pub mean: f64,
    /// Its variance.
    pub variance: f64,
}

fn of(mean: f64, variance: f64) -> Moments2 {
    Moments2 { mean, variance }
}

/// Variance of Y = 4x, x uniform on [0, 4].
const VARIANCE: f64 = 64.0 / 3.0;

/// Mean of n values Y.
pub fn mean(n: u32) -> Moments2 {
    of(8.0, VARIANCE / f64::from(n))
}

/// The first of them.
pub fn first(_: u32) -> Moments2 {
    of(8.0, VARIANCE)
}

/// Importance sampling by (x + 2)/16.
pub fn importance(n: u32) -> Moments2 {
    let density = LinearDensity {
        constant: 0.125,
        slope: 0.0625,
    };
    of(8.0, density.variance() / f64::from(n))
}

/// 1/mean of n values Y = 16u: A = n, B = ΣY, ψ(t) = (1 − e^(−16t))/(16t). Its variance is finite
/// from n = 3 on.
pub fn reciprocal(n: u32) -> Moments2 {
    let count = f64::from(n);
    // With s = 16t the n-th power of (1 − e^−s)/s.
    let power = |s: f64| {
        let psi = if s < 1e-9 { 1.0 } else { -(-s).exp_m1() / s };
        psi.powi(n as i32)
    };
    // Where it is nothing, or from 60 on, where it is s^−n to 1e-26.
    let cuts = (0..).map(|k| 60.0 * (-f64::from(k)).exp2());
    let cut = cuts.take_while(|&s| s > 59.0 || power(s) < 1e-25).last();
    let cut: f64 = cut.unwrap_or(60.0);
    let tail = |moment: f64| {
        if cut > 59.0 {
            cut.powf(moment - count) / (count - moment)
        } else {
            0.0
        }
    };
    let first = over(power, cut) + tail(1.0);
    let second = over(|s| s * power(s), cut) + tail(2.0);
    let mean = count / 16.0 * first;
    of(mean, (count / 16.0).powi(2) * second - mean * mean)
}

/// 4·Σ(x/p)/Σ(1/p), x drawn by p = (6 − x)/16: a = 4x/p, b = 1/p.
pub fn normalised(n: u32) -> Moments2 {
    let count = f64::from(n);
    let nodes: Vec<(f64, f64)> = Rule::Gauss.points(100);
    // E[g(x)] = ∫₀⁴ p g dx.
    let expectation = |g: &dyn Fn(f64, f64) -> f64| -> f64 {
        let terms = nodes.iter().map(|&(u, weight)| {
            let x = 4.0 * u;
            let p = (6.0 - x) / 16.0;
            4.0 * weight * p * g(x, p)
        });
        terms.sum()
    };
    // ψ falls at least as e^(−8t/3).
    let cut = 45.0 / (count * 8.0 / 3.0);
    let (mut mean, mut square) = (0.0, 0.0);
    for (u, weight) in Rule::Gauss.points(1600) {
        let t = cut * u;
        let psi = expectation(&|_, p| (-t / p).exp());
        let a = expectation(&|x, p| 4.0 * x / p * (-t / p).exp());
        let aa = expectation(&|x, p| (4.0 * x / p).powi(2) * (-t / p).exp());
        let less = psi.powi(n as i32 - 2);
        mean += cut * weight * count * a * less * psi;
        square += cut * weight * t * count * less * (aa * psi + (count - 1.0) * a * a);
    }
    of(mean, square - mean * mean)
}

/// The largest of n values x: (x/4)ⁿ is its distribution function.
pub fn maximum(n: u32) -> Moments2 {
    let n = f64::from(n);
    of(
        4.0 * n / (n + 1.0),
        16.0 * n / ((n + 1.0) * (n + 1.0) * (n + 2.0)),
    )
}

/// Σ(Y − mean)²/n: (n − 1)/n times the unbiased one, whose variance is V²(κ − (n−3)/(n−1))/n with κ =
/// 9/5.
pub fn spread(n: u32) -> Moments2 {
    let n = f64::from(n);
    let factor = (n - 1.0) / n;
    let unbiased = VARIANCE * VARIANCE * (1.8 - (n - 3.0) / (n - 1.0)) / n;
    of(VARIANCE * factor, unbiased * factor * factor)
}

/// Mean of min(Y, 12), whose own mean is 7.5 and whose mean square is 72.
pub fn clamped(n: u32) -> Moments2 {
    of(7.5, 15.75 / f64::from(n))
}

/// 4·2².
pub fn center(_: u32) -> Moments2 {
    of(16.0, 0.0)
}

/// The sum of the squares of ½, 1½, 2½, 3½; n is a multiple of four.
pub fn grid(_: u32) -> Moments2 {
    of(21.0, 0.0)
}

/// Mean of 3x, x uniform on [0, 3].
pub fn part(n: u32) -> Moments2 {
    of(4.5, 6.75 / f64::from(n))
}

/// Mean of u^(−2/3)/3.
pub fn light_tail(_: u32) -> Moments2 {
    of(1.0, f64::INFINITY)
}

/// P(u^(−2/3)/3 ≤ 1) = 1 − 3^(−3/2).
pub fn light_tail_below_one() -> f64 {
    1.0 - 3_f64.powf(-1.5)
}

/// Moments of min(u^(−2/3)/3, 10): clamped below u₀ = 30^(−3/2).
pub fn light_tail_clamped() -> Moments2 {
    let u = 30_f64.powf(-1.5);
    let mean = 10.0 * u + 1.0 - u.cbrt();
    let square = 100.0 * u + (1.0 / u.cbrt() - 1.0) / 3.0;
    of(mean, square - mean * mean)
}

/// ∫₀^high f by Gauss's rule, finer near 0.
fn over(f: impl Fn(f64) -> f64, high: f64) -> f64 {
    let points = Rule::Gauss.points(4000).into_iter();
    points
        .map(|(u, weight)| 2.0 * u * high * weight * f(u * u * high))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reciprocals_of_many_follow_the_delta_method() {
        // The delta method: bias V/(nθ³), variance V/(nθ⁴), to a relative O(1/n).
        let n = 4096;
        let found = reciprocal(n);
        let bias = VARIANCE / (f64::from(n) * 512.0);
        assert!(((found.mean - 0.125) / bias - 1.0).abs() < 1e-3);
        let variance = VARIANCE / (f64::from(n) * 4096.0);
        assert!((found.variance / variance - 1.0).abs() < 2e-3);
    }

    #[test]
    fn the_reciprocal_of_two_is_the_closed_form() {
        // E[2/(Y₁ + Y₂)] with Y = 16u: (1/8)·E[1/(u₁ + u₂)] = (1/8)·2 ln 2. The tail of the second
        // moment diverges.
        let found = reciprocal(2).mean;
        assert!((found - 0.25 * 2_f64.ln()).abs() < 1e-9, "{found}");
    }

    #[test]
    fn the_normalised_estimate_of_one_sample_is_four_times_its_place() {
        // n = 1: the weight cancels; E[4x] = ∫ 4x(6 − x)/16 dx = 20/3, and n = 1 needs no ψ.
        let found = normalised(1).mean;
        assert!((found - 20.0 / 3.0).abs() < 1e-6, "{found}");
        // The delta method: θ(V[b]/β² − C[a, b]/(αβ))/n, with E a = 32, E b = 4, E b² = 16 ln 3, E
        // ab = 64(6 ln 3 − 4).
        let ln3 = 3_f64.ln();
        let bias = 8.0 * (ln3 - (6.0 * ln3 - 4.0) * 64.0 / 128.0) / 4096.0;
        let found = normalised(4096);
        assert!(
            ((found.mean - 8.0) / bias - 1.0).abs() < 1e-2,
            "{found:?} {bias}"
        );
    }

    #[test]
    fn clamped_moments_are_the_integrals() {
        let of_u = |f: &dyn Fn(f64) -> f64| -> f64 {
            let points = Rule::Gauss.points(20_000).into_iter();
            // u = v³ makes the integrand smooth but for the clamp's edge.
            points.map(|(v, w)| 3.0 * v * v * w * f(v.powi(3))).sum()
        };
        let w = |u: f64| (u.powf(-2.0 / 3.0) / 3.0).min(10.0);
        let due = light_tail_clamped();
        assert!((of_u(&w) - due.mean).abs() < 1e-6);
        let square = of_u(&|u| w(u).powi(2));
        assert!((square - due.mean.powi(2) - due.variance).abs() < 1e-5);
    }
}
