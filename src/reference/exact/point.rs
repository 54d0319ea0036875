//! Irradiance from lights without area.

use glam::DVec3;

/// Irradiance from a point light of radiant `intensity` I: I cosθ/d². 0 below the horizon, and at
/// the light itself.
pub fn point_irradiance(point: DVec3, normal: DVec3, light: DVec3, intensity: f64) -> f64 {
    let to_light = light - point;
    let d2 = to_light.length_squared();
    let rise = to_light.dot(normal);
    if rise <= 0.0 {
        return 0.0;
    }
    intensity * rise / (d2 * d2.sqrt())
}

/// Irradiance from a directional light that comes from unit direction `towards`, of irradiance
/// `perpendicular` on a surface that faces it: perpendicular·cosθ.
pub fn directional_irradiance(normal: DVec3, towards: DVec3, perpendicular: f64) -> f64 {
    perpendicular * normal.dot(towards).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE 171:2006, 5.2: a Lambertian point source of 1000 cd at height 3, so of 1000·cosθ cd.
    #[test]
    fn illuminance_below_a_point_source() {
        let cases = [
            ((0.0, 0.0), 111.111),
            ((0.5, 0.0), 105.186),
            ((1.0, 0.0), 90.000),
            ((1.5, 0.0), 71.111),
            ((0.5, 0.5), 99.723),
            ((1.0, 0.5), 85.663),
            ((1.5, 0.5), 68.053),
            ((1.0, 1.0), 74.380),
            ((1.5, 1.0), 59.975),
            ((1.5, 1.5), 49.383),
        ];
        for ((x, y), expected) in cases {
            let (point, light) = (DVec3::new(x, y, 0.0), DVec3::Z * 3.0);
            let intensity = 1000.0 * (light - point).normalize().z;
            let lux = point_irradiance(point, DVec3::Z, light, intensity);
            assert!((lux - expected).abs() < 0.5e-3, "{x} {y}: {lux}");
        }
    }

    #[test]
    fn nothing_comes_from_below() {
        assert!(point_irradiance(DVec3::ZERO, DVec3::Z, -DVec3::Z, 1.0) <= 0.0);
        assert!(point_irradiance(DVec3::ZERO, DVec3::Z, DVec3::ZERO, 1.0) <= 0.0);
        assert!(directional_irradiance(DVec3::Z, -DVec3::Z, 1.0) <= 0.0);
    }
}
