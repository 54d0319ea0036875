//! Why an image cannot tell its error.

use super::chance::SquaredError;
use std::fmt;

/// Why an image cannot tell its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// One pixel holds this part of it.
    OnePixel(f64),
    /// No more than so many pixels share it.
    FewPixels(f64),
    /// What it is divided by pixel by pixel is not known well enough.
    Denominators,
    /// The image's mean has this relative standard error.
    Mean(f64),
    /// Small lights, which samples nearly met, should have added so many times as much.
    MissedLight(f64),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnePixel(part) => write!(f, "one pixel holds {:.0} % of it", 100.0 * part),
            Self::FewPixels(pixels) => {
                write!(f, "it is as uncertain as that of {pixels:.0} pixels")
            }
            Self::MissedLight(times) => write!(
                f,
                "small lights that samples nearly met should add {times:.1} times as much"
            ),
            Self::Denominators => f.write_str("pixels are too noisy to divide by"),
            Self::Mean(relative) => write!(
                f,
                "the image's mean has a standard error of {:.0} %",
                100.0 * relative
            ),
        }
    }
}

impl SquaredError {
    /// Why chance may have taken it far from the actual error.
    pub(super) fn doubt(&self) -> Doubt {
        let of_one = self.largest / self.sum;
        if of_one >= 0.5 {
            Doubt::OnePixel(of_one)
        } else {
            Doubt::FewPixels(self.freedom().max(1.0))
        }
    }
}
