//! A density is a type: mixing measures does not compile.

/// Density per unit area of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PdfArea(pub f64);

/// Density per unit solid angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PdfSolidAngle(pub f64);

/// Probability of one of finitely many choices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PdfDiscrete(pub f64);

/// dω = cosθ_light / d² · dA. `cos_light` > 0 is the cosine at the light, `distance_squared` > 0.
pub fn area_to_solid_angle(pdf: PdfArea, distance_squared: f64, cos_light: f64) -> PdfSolidAngle {
    PdfSolidAngle(pdf.0 * distance_squared / cos_light.max(1e-12))
}

/// Density of choosing a light and then a direction towards it.
pub fn chosen(choice: PdfDiscrete, pdf: PdfSolidAngle) -> PdfSolidAngle {
    PdfSolidAngle(choice.0 * pdf.0)
}

/// Weight of the strategy with density `a` when `b` could have made the same sample: a² / (a² + b²)
/// (Veach 1997, eq. 9.26). 0 where both are 0.
pub fn power_heuristic(a: PdfSolidAngle, b: PdfSolidAngle) -> f64 {
    let larger = a.0.max(b.0);
    if larger <= 0.0 {
        return 0.0;
    }
    let (a, b) = (a.0 / larger, b.0 / larger);
    a * a / (a * a + b * b)
}

/// The same with exponent 1: a / (a + b) (Veach 1997, eq. 9.11, the balance heuristic).
pub fn balance_heuristic(a: PdfSolidAngle, b: PdfSolidAngle) -> f64 {
    let larger = a.0.max(b.0);
    if larger <= 0.0 {
        return 0.0;
    }
    let (a, b) = (a.0 / larger, b.0 / larger);
    a / (a + b)
}

/// Density of `samples` samples together, each of which has the density `pdf`: what stands for it
/// in the weights of several samples (Veach 1997, eq. 9.8).
pub fn of_samples(samples: u32, pdf: PdfSolidAngle) -> PdfSolidAngle {
    PdfSolidAngle(f64::from(samples) * pdf.0)
}
