//! What smooth surfaces reflect of unpolarised light, for what the host computes of a material.

/// Points of [`average`]: the midpoint rule is then within 1e-7 of the integral.
const POINTS: u32 = 2048;

/// Reflectance of a dielectric with relative index of refraction `eta` = n_t/n_i > 0 at an incident
/// cosine in [0, 1].
pub fn dielectric_reflectance(cos_i: f64, eta: f64) -> f64 {
    let difference = (eta - 1.0) * (eta + 1.0);
    let squared = cos_i * cos_i + difference;
    if squared <= 0.0 {
        return if difference < 0.0 { 1.0 } else { 0.0 };
    }
    let eta_cos_t = squared.sqrt();
    let s = difference / (cos_i + eta_cos_t).powi(2);
    let p = difference * ((eta * eta + 1.0) * cos_i * cos_i - 1.0)
        / (eta * eta * cos_i + eta_cos_t).powi(2);
    0.5 * (s * s + p * p)
}

/// Reflectance of a conductor with complex index of refraction `eta` + i·`k`, `eta` > 0, `k` ≥ 0
/// (Born & Wolf 1999, section 14.2): with (a + ib)² = (η + ik)² − sin²θ
///
/// ```text
///     R_s = |c − a − ib|²/|c + a + ib|²,   R_p = R_s·|a + ib − sin²θ/c|²/|a + ib + sin²θ/c|²,   c = cosθ
/// ```
pub fn conductor_reflectance(cos_i: f64, eta: f64, k: f64) -> f64 {
    let c2 = cos_i * cos_i;
    let s2 = 1.0 - c2;
    let re = eta * eta - k * k - s2;
    let im = 2.0 * eta * k;
    let modulus = re.hypot(im);
    // (modulus + re)/2, which cancels where the real part is negative.
    let a2 = if re > 0.0 {
        0.5 * (modulus + re)
    } else {
        0.5 * im * im / (modulus - re).max(f64::MIN_POSITIVE)
    };
    let t = 2.0 * a2.sqrt() * cos_i;
    let s = (c2 + modulus - t) / (c2 + modulus + t).max(f64::MIN_POSITIVE);
    let u = c2 * modulus + s2 * s2;
    let p = s * (u - t * s2) / (u + t * s2).max(f64::MIN_POSITIVE);
    0.5 * (s + p)
}

/// 2∫f(μ)μ dμ over the cosines μ in [0, 1]: the mean over the directions of uniform radiance.
pub fn average(f: impl Fn(f64) -> f64) -> f64 {
    let step = 1.0 / f64::from(POINTS);
    let values = (0..POINTS).map(|i| {
        let cos = (f64::from(i) + 0.5) * step;
        2.0 * f(cos) * cos * step
    });
    values.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::exact::fresnel;

    /// The reference's 1 − sin²θ_t loses digits where that is small: at grazing angles between
    /// indices that are all but equal.
    #[test]
    fn dielectrics_are_fresnels() {
        for eta in [1.0, 1.000_001, 1.5, 2.4, 1.0 / 1.5] {
            for cos in [1e-6, 0.1, 0.5, 0.7, 0.8, 1.0] {
                let exact = fresnel::dielectric_reflectance(cos, eta);
                let left = cos * cos + (eta * eta - 1.0).abs();
                let bound = 1e-14 + 4.0 * f64::EPSILON / left;
                assert!((dielectric_reflectance(cos, eta) - exact).abs() < bound);
            }
        }
    }

    /// Without absorption a conductor is a dielectric; at normal incidence R = ((η−1)² +
    /// k²)/((η+1)² + k²).
    #[test]
    fn conductors_have_the_known_limits() {
        for cos in [0.05, 0.4, 0.99] {
            let found = conductor_reflectance(cos, 1.5, 0.0);
            assert!(
                (found - dielectric_reflectance(cos, 1.5)).abs() < 1e-14,
                "{cos}"
            );
        }
        for (eta, k) in [(0.05, 4.1), (1.3, 1.9), (0.96, 6.4)] {
            let exact = ((eta - 1.0_f64).powi(2) + k * k) / ((eta + 1.0_f64).powi(2) + k * k);
            assert!((conductor_reflectance(1.0, eta, k) - exact).abs() < 1e-14);
            assert!((conductor_reflectance(0.0, eta, k) - 1.0).abs() < 1e-14);
        }
    }

    /// 0.0917… for glass: the sum of Walsh's closed form (1926).
    #[test]
    fn the_average_of_glass_is_known() {
        let eta: f64 = 1.5;
        let e2 = eta * eta;
        let e4 = e2 * e2;
        let exact = 0.5
            + (eta - 1.0) * (3.0 * eta + 1.0) / (6.0 * (eta + 1.0).powi(2))
            + e2 * (e2 - 1.0).powi(2) / (e2 + 1.0).powi(3) * ((eta - 1.0) / (eta + 1.0)).ln()
            - 2.0 * eta * e2 * (e2 + 2.0 * eta - 1.0) / ((e2 + 1.0) * (e4 - 1.0))
            + 8.0 * e4 * (e4 + 1.0) / ((e2 + 1.0) * (e4 - 1.0).powi(2)) * eta.ln();
        let found = average(|cos| dielectric_reflectance(cos, eta));
        assert!((found - exact).abs() < 1e-6, "{found}, not {exact}");
    }
}
