//! How far an image is from the truth, as one number.

use super::choice::choice;

choice! {
    /// How far an image x is from the truth r, as one number.
    pub enum ErrorMetric {
        /// Mean squared error over the squared mean: the mean over pixels and channels of (x −
        /// r)², over mean(r)². What it divides by is known, so that an image can tell it.
        #[default]
        Nmse,
        /// Relative mean squared error: the mean over pixels and channels of (x − r)² / (r² +
        /// 0.01·mean(r)²). Dark pixels count as much as bright ones; what it divides by has to be
        /// guessed where pixels are noisy.
        RelMse,
    }
}

impl ErrorMetric {
    /// As it is written in text.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Nmse => "NMSE",
            Self::RelMse => "relMSE",
        }
    }
}
