//! Cutoffs of masks whose α comes from an image.
//!
//! Textures hold α in 16 bits, and interpolation rounds. A cutoff is therefore moved to where it
//! divides the rounded values as the one in the file divides the image's own.

use crate::scene::Opacity;
use half::f16;

/// Relative distance that is kept between a cutoff and the values of texels: what interpolating
/// equal ones in f32 rounds away, 2⁻²⁴ per operation.
const MARGIN: f64 = 1.0 / 2_097_152.0;

/// The α of a texel: what the image says, and what the texture holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alpha {
    pub(super) exact: f64,
    pub(super) held: f16,
}

impl Alpha {
    /// That of a texel from an image of 8 bits per channel.
    pub(super) fn of_byte(held: f16) -> Self {
        let level = (held.to_f64() * 255.0).round();
        Self {
            exact: level / 255.0,
            held,
        }
    }
}

/// The held values on either side of a cutoff.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sides {
    /// The largest that the cutoff makes transparent.
    transparent: Option<f16>,
    /// The smallest that it makes opaque.
    opaque: Option<f16>,
}

/// Whether `alpha` reaches the cutoff: compared as 32-bit floats, as glTF's numbers are, so that
/// 51/255 reaches 0.2.
fn reaches(opacity: &Opacity, cutoff: f64, alpha: f64) -> bool {
    (opacity.factor * alpha) as f32 >= cutoff as f32
}

fn sides(opacity: &Opacity, cutoff: f64, alphas: impl Iterator<Item = Alpha>) -> Sides {
    let none = Sides {
        transparent: None,
        opaque: None,
    };
    alphas.fold(none, |sides, alpha| {
        if reaches(opacity, cutoff, alpha.exact) {
            let least = sides.opaque.map_or(alpha.held, |h| h.min(alpha.held));
            return Sides {
                opaque: Some(least),
                ..sides
            };
        }
        let most = sides.transparent.map_or(alpha.held, |h| h.max(alpha.held));
        Sides {
            transparent: Some(most),
            ..sides
        }
    })
}

/// Moves the cutoff of `opacity`, whose texture has these `alphas`. Returns the held α of which
/// some texels are opaque and some transparent, where there is one: the transparent ones are to be
/// held as the next smaller number.
pub(super) fn settle(
    opacity: &mut Opacity,
    alphas: impl Iterator<Item = Alpha>,
) -> Option<Divided> {
    // What is out of its domain is refused later, by its own value.
    let valid = |cutoff: &f64| cutoff.is_finite() && *cutoff >= 0.0;
    let factor_valid = (0.0..=1.0).contains(&opacity.factor);
    let cutoff = opacity.cutoff.filter(valid).filter(|_| factor_valid)?;
    let Sides {
        transparent,
        opaque,
    } = sides(opacity, cutoff, alphas);
    let divided = transparent.filter(|t| Some(*t) == opaque);
    let transparent = match divided {
        Some(held) => Some(next_below(held)),
        None => transparent,
    };
    let product = |held: f16| opacity.factor * held.to_f64();
    let least = transparent.map_or(0.0, |h| product(h) * (1.0 + MARGIN));
    let most = opaque.map_or(f64::INFINITY, |h| product(h) * (1.0 - MARGIN));
    // Smaller numbers are 0 for some devices.
    let normal = if cutoff > 0.0 {
        cutoff.max(f32::MIN_POSITIVE.into())
    } else {
        cutoff
    };
    opacity.cutoff = Some(normal.max(least).min(most));
    divided.map(|held| Divided {
        held,
        cutoff,
        opacity: *opacity,
    })
}

fn next_below(held: f16) -> f16 {
    f16::from_bits(held.to_bits().saturating_sub(1))
}

/// A held α that stands for texels on both sides of a cutoff.
#[derive(Debug, Clone, Copy)]
pub(super) struct Divided {
    held: f16,
    cutoff: f64,
    opacity: Opacity,
}

impl Divided {
    /// What the texel `alpha` is to be held as.
    pub(super) fn apart(&self, alpha: Alpha) -> f16 {
        let below = alpha.held == self.held && !reaches(&self.opacity, self.cutoff, alpha.exact);
        if below {
            next_below(alpha.held)
        } else {
            alpha.held
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn byte(level: u32) -> Alpha {
        Alpha::of_byte(f16::from_f64(f64::from(level) / 255.0))
    }

    fn mask(factor: f64, cutoff: f64) -> Opacity {
        Opacity {
            factor,
            texture: None,
            cutoff: Some(cutoff),
        }
    }

    /// What an image of all 256 levels is under `opacity` once its cutoff is settled: opaque from
    /// the level that is returned.
    fn first_opaque(opacity: Opacity) -> u32 {
        let mut opacity = opacity;
        let divided = settle(&mut opacity, (0..256).map(byte));
        assert!(divided.is_none(), "8 bits stay apart in 16");
        let at = |level: u32| opacity.at(byte(level).held.to_f64()) > 0.0;
        let first = (0..256).find(|&level| at(level)).unwrap_or(256);
        assert!((first..256).all(at), "{opacity:?}");
        first
    }

    #[test]
    fn levels_of_8_bits_reach_cutoffs_that_equal_them() {
        for level in 1..256 {
            let exact = f64::from(level) / 255.0;
            for written in [exact, f64::from(exact as f32)] {
                assert_eq!(first_opaque(mask(1.0, written)), level, "{written}");
            }
            let above = f64::from((exact as f32).next_up());
            assert_eq!(first_opaque(mask(1.0, above)), level + 1, "{above}");
            let below = f64::from((exact as f32).next_down());
            assert_eq!(first_opaque(mask(1.0, below)), level, "{below}");
        }
        for (factor, cutoff, level) in [(1.0, 0.2, 51), (0.9, 0.36, 102), (0.5, 0.5, 255)] {
            assert_eq!(first_opaque(mask(factor, cutoff)), level, "{cutoff}");
        }
        assert_eq!(first_opaque(mask(1.0, 0.0)), 0);
        assert_eq!(first_opaque(mask(1.0, 1e-42)), 1);
        assert_eq!(first_opaque(mask(1.0, 1.5)), 256);
    }

    /// Between texels of one value interpolation gives that value but for its rounding, which must
    /// not reach the cutoff.
    #[test]
    fn cutoffs_keep_a_distance_from_texels() {
        for level in 1..255 {
            let mut opacity = mask(1.0, f64::from(level) / 255.0);
            settle(&mut opacity, (0..256).map(byte));
            let cutoff = opacity.cutoff.expect("a mask") as f32;
            let [below, at] = [level - 1, level].map(|l| byte(l).held.to_f32());
            assert!(below * (1.0 + 4.0 * f32::EPSILON) < cutoff, "{level}");
            assert!(at * (1.0 - 2.0 * f32::EPSILON) >= cutoff, "{level}");
        }
    }

    /// A cutoff that divides the held values as it is stays as it is.
    #[test]
    fn cutoffs_stay_where_they_may() {
        let mut opacity = mask(0.7, 0.3);
        settle(&mut opacity, (0..256).map(byte));
        assert_eq!(opacity, mask(0.7, 0.3));
    }

    #[test]
    fn levels_of_16_bits_are_held_apart() {
        let word = |level: u32| {
            let exact = f64::from(level) / 65_535.0;
            let held = f16::from_f64(exact);
            Alpha { exact, held }
        };
        let levels = [0, 32_766, 32_767, 32_768, 32_769, 65_535];
        let mut opacity = mask(1.0, 0.5);
        let divided = settle(&mut opacity, levels.into_iter().map(word)).expect("one value");
        let opaque = levels.map(|l| opacity.at(divided.apart(word(l)).to_f64()) > 0.0);
        assert_eq!(opaque, [false, false, false, true, true, true]);
    }
}
