//! Uniform points on disks and ellipses, as coordinates (s, t): the point is center + s·u + t·v, s² +
//! t² ≤ 1.

pub use crate::emitters::area_map::{
    disk_to_square as invert_disk_area, square_to_disk as sample_disk_area,
};
use crate::reference::core::pdf::PdfArea;

/// Density of [`sample_disk_area`] on an ellipse of area `area`.
pub fn pdf_disk_area(area: f64) -> PdfArea {
    PdfArea(1.0 / area)
}
