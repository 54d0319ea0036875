//! Metals by name: complex indices of refraction, after Johnson & Christy 1972, "Optical Constants
//! of the Noble Metals", Physical Review B 6, table I, interpolated in photon energy at 611.4,
//! 549.1 and 464.2 nm, the dominant wavelengths of Rec. 709's primaries.

use super::choice::choice;
use glam::DVec3;

choice! {
    /// A metal whose index of refraction is known.
    pub enum Metal {
        /// Copper.
        #[default]
        Copper,
        /// Gold.
        Gold,
        /// Silver.
        Silver,
    }
}

impl Metal {
    /// Index of refraction, real part, and extinction coefficient.
    pub fn index(self) -> (DVec3, DVec3) {
        let (eta, k) = match self {
            Self::Copper => ([0.355, 1.015, 1.247], [3.136, 2.579, 2.454]),
            Self::Gold => ([0.221, 0.428, 1.334], [3.216, 2.462, 1.871]),
            Self::Silver => ([0.059, 0.060, 0.047], [4.112, 3.591, 2.797]),
        };
        (DVec3::from_array(eta), DVec3::from_array(k))
    }
}
