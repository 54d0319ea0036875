//! Uniform points on triangles, as coordinates (s, t): the point is a + s·(b − a) + t·(c − a).

use crate::reference::core::pdf::PdfArea;
use glam::DVec2;

/// Area-preserving map from the square to the triangle (Heitz 2019, "A Low-Distortion Map Between Triangle and
/// Square").
pub fn sample_triangle_area(u: DVec2) -> DVec2 {
    if u.y > u.x {
        let s = 0.5 * u.x;
        DVec2::new(s, u.y - s)
    } else {
        let t = 0.5 * u.y;
        DVec2::new(u.x - t, t)
    }
}

/// Density of [`sample_triangle_area`] on a triangle of area `area`.
pub fn pdf_triangle_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}
