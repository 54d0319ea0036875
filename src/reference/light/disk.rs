//! Uniform points on disks and ellipses, as coordinates (s, t): the point is center + s·u + t·v, s² + t² ≤ 1.

use crate::reference::core::math::sin_cos_octant;
use crate::reference::core::pdf::PdfArea;
use glam::DVec2;
use std::f64::consts::FRAC_PI_4;

/// Concentric map (Shirley & Chiu 1997, "A Low Distortion Map Between Disk and Square"). The centre maps to itself.
pub fn sample_disk_area(u: DVec2) -> DVec2 {
    let p = 2.0 * u - DVec2::ONE;
    let wide = p.x.abs() > p.y.abs();
    let (radius, across) = if wide { (p.x, p.y) } else { (p.y, p.x) };
    if radius == 0.0 {
        return DVec2::ZERO;
    }
    let sc = sin_cos_octant(FRAC_PI_4 * across / radius);
    radius * if wide { DVec2::new(sc.y, sc.x) } else { sc }
}

/// Density of [`sample_disk_area`] on an ellipse of area `area`.
pub fn pdf_disk_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}
