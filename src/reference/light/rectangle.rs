//! Uniform points on parallelograms, as coordinates (s, t): the point is corner + s·u + t·v.

use crate::reference::core::pdf::PdfArea;
use glam::DVec2;

/// The square is the parallelogram.
pub fn sample_rectangle_area(u: DVec2) -> DVec2 {
    u
}

/// Density of [`sample_rectangle_area`] on a parallelogram of area `area`.
pub fn pdf_rectangle_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}
