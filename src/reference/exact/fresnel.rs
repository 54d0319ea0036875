//! Fresnel's equations for unpolarised light and a dielectric.

/// Reflectance at an interface with relative index of refraction `eta` = n_t/n_i > 0, the incident
/// direction at an angle with cosine `cos_i` in [0, 1]. 1 in total reflection.
pub fn dielectric_reflectance(cos_i: f64, eta: f64) -> f64 {
    reflectance_of_excess(cos_i, eta - 1.0)
}

/// [`dielectric_reflectance`] for `eta` = 1 + `excess`, exact also where the indices are all but
/// equal:
///
/// ```text
///     r_s = −(η²−1)/(c + ηt)²,   r_p = (η²−1)((η²+1)c² − 1)/(η²(ηc + t)²),   c = cosθ_i, t = cosθ_t
/// ```
///
/// which are Fresnel's amplitudes (c − ηt)/(c + ηt) and (ηc − t)/(ηc + t), multiplied out.
pub fn reflectance_of_excess(cos_i: f64, excess: f64) -> f64 {
    let eta = 1.0 + excess;
    let difference = excess * (2.0 + excess);
    let sin2_t = (1.0 - cos_i) * (1.0 + cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        // Equal indices reflect nothing, also where nothing comes in.
        return if excess.abs() > 0.0 { 1.0 } else { 0.0 };
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = difference / (cos_i + eta * cos_t).powi(2);
    let p = difference * ((eta * eta + 1.0) * cos_i * cos_i - 1.0)
        / (eta * (eta * cos_i + cos_t)).powi(2);
    0.5 * (s * s + p * p)
}

/// Angle of incidence in radians from which on all is reflected; `None` when `eta` ≥ 1.
pub fn critical_angle(eta: f64) -> Option<f64> {
    (eta < 1.0).then(|| eta.asin())
}

/// Brewster's angle of incidence in radians, at which the component in the plane of incidence is
/// not reflected.
pub fn brewster_angle(eta: f64) -> f64 {
    eta.atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_are_fresnels() {
        for eta in [1.5_f64, 1.33, 2.4, 0.7] {
            for degrees in [0.0_f64, 10.0, 35.0, 40.0] {
                let c = degrees.to_radians().cos();
                let t = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
                let s = (c - eta * t) / (c + eta * t);
                let p = (eta * c - t) / (eta * c + t);
                let expected = 0.5 * (s * s + p * p);
                assert!((dielectric_reflectance(c, eta) - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn limits() {
        assert!((dielectric_reflectance(0.0, 1.5) - 1.0).abs() < 1e-15);
        assert!((dielectric_reflectance(0.5, 1.0 / 1.5) - 1.0).abs() < 1e-15);
        assert!(dielectric_reflectance(0.0, 1.0) <= 0.0 && dielectric_reflectance(0.7, 1.0) <= 0.0);
        assert!(critical_angle(1.5).is_none());
        // The reflectance from inside at the refracted angle is the same.
        let c = 0.6_f64;
        let t = (1.0 - (1.0 - c * c) / 2.25).sqrt();
        assert!(
            (dielectric_reflectance(c, 1.5) - dielectric_reflectance(t, 1.0 / 1.5)).abs() < 1e-15
        );
    }
}
