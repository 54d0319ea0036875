//! From radiance to display values.

/// How radiance above what a display can show is treated.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    strum::Display,
    strum::EnumMessage,
    strum::VariantArray,
)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[strum(serialize_all = "kebab-case")]
pub enum ToneMapper {
    /// Values above 1 are cut off; all below are shown as they are.
    #[default]
    Clip,
    /// x / (1 + x) on the luminance (Reinhard et al. 2002, eq. 3).
    Reinhard,
    /// A fit to the ACES filmic curve, per channel (Narkowicz 2016).
    Aces,
}

impl ToneMapper {
    /// Linear display values in [0, 1] for linear radiance that the exposure has been applied to.
    pub fn map(self, rgb: [f64; 3]) -> [f64; 3] {
        let rgb = rgb.map(|x| x.max(0.0));
        let mapped = match self {
            Self::Clip => rgb,
            Self::Reinhard => {
                let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
                rgb.map(|x| x / (1.0 + luminance))
            }
            Self::Aces => rgb.map(|x| (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)),
        };
        mapped.map(|x| x.min(1.0))
    }
}

/// sRGB encoding of a linear value in [0, 1] (IEC 61966-2-1).
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The same in 8 bits.
pub fn srgb_8_bit(linear: f64) -> u8 {
    (srgb(linear) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mapper_stays_in_range_and_keeps_black() {
        for mapper in [ToneMapper::Clip, ToneMapper::Reinhard, ToneMapper::Aces] {
            for x in [-1.0, 0.0, 1e-6, 0.18, 1.0, 10.0, 1e6] {
                for y in mapper.map([x, x, 0.5 * x]) {
                    assert!((0.0..=1.0).contains(&y), "{mapper:?} {x} {y}");
                }
            }
            assert!(mapper.map([0.0; 3]).iter().all(|&y| y < 1e-12));
        }
    }

    #[test]
    fn srgb_is_continuous_and_known_at_middle_grey() {
        assert!((srgb(0.003_130_8) - srgb(0.003_130_8 + 1e-12)).abs() < 1e-6);
        assert!((srgb(0.214_041_14) - 0.5).abs() < 1e-6);
        assert!((srgb(1.0) - 1.0).abs() < 1e-12);
    }
}
