//! The grid that the boxes of the hierarchy are rounded to, 16 bits per plane.

use glam::{DVec3, Vec3};

/// Cells of the even grid per axis.
const CELLS: f64 = 65_535.0;
/// Boxes grow by this many cells before they are rounded outwards: more than the slab test's
/// rounding, which is at most 2⁻²⁴ of the grid per operation.
const PADDING: f64 = 0.0625;
/// On the logarithmic grid they grow by this part of their distance from the centre: more than the
/// slab test's rounding.
const RELATIVE_PADDING: f64 = 1.0 / 2048.0;
/// And by this part of the box's largest coordinate: a primitive so far away is met within as much
/// beside itself.
const FAR_PADDING: f64 = 1.0 / 1_048_576.0;
/// And by this part of the radius within which rays begin that the camera can tell from others.
const NEAR_PADDING: f64 = 1.0 / 16_384.0;
/// The word of a plane is the upper half of an f32 without the exponent's two highest bits, which
/// are 01: those of its exponents are −63 to 0.
const LOWEST_EXPONENT: u32 = 0x2000_0000;
/// Bits of an f32 below those of a plane's word.
const SHIFT: u32 = 14;
/// Set in the words of negative planes.
const NEGATIVE: u32 = 0x8000;

/// Where planes may lie. Origin and scale are those of the GPU, in f32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Lower corner of an even grid, 0 of a logarithmic one; normalised space.
    pub origin: Vec3,
    /// Cells per unit length, or what maps the scene to [−1, 1].
    pub scale: Vec3,
    /// Whether planes lie closer together the nearer they are to the centre: where a scene is
    /// extreme.
    pub logarithmic: bool,
    /// What planes of a logarithmic grid are moved outwards by, in units of the grid.
    padding: f64,
}

impl Default for Grid {
    fn default() -> Self {
        Self {
            origin: Vec3::ZERO,
            scale: Vec3::ONE,
            logarithmic: false,
            padding: 0.0,
        }
    }
}

impl Grid {
    /// The even grid over a box.
    pub fn even(low: DVec3, high: DVec3) -> Self {
        // One cell of margin on each side, and no axis without extent.
        let extent = (high - low).max(DVec3::splat((high - low).max_element() * 1e-3 + 1e-30));
        let scale = (DVec3::splat(CELLS - 2.0) / extent).as_vec3();
        Self {
            origin: (low - DVec3::ONE / scale.as_dvec3()).as_vec3(),
            scale,
            ..Self::default()
        }
    }

    /// The logarithmic grid over coordinates up to `reach`, for rays that begin within about
    /// `radius` of the centre.
    pub fn logarithmic(reach: f64, radius: f64) -> Self {
        let scale = (-reach.log2().ceil()).exp2();
        Self {
            origin: Vec3::ZERO,
            scale: Vec3::splat(scale as f32),
            logarithmic: true,
            padding: NEAR_PADDING * radius * scale,
        }
    }

    /// The words of a box of normalised space, as a node has them, with a cell of margin.
    pub fn box_words_with_margin(&self, low: DVec3, high: DVec3) -> [u32; 3] {
        let cell = if self.logarithmic {
            DVec3::ZERO
        } else {
            DVec3::ONE / self.scale.as_dvec3()
        };
        self.box_words((low - cell).as_vec3(), (high + cell).as_vec3())
    }

    /// The words of a box of normalised space, as a node has them: the planes of an axis each,
    /// moved outwards, the lower one in the low half.
    pub fn box_words(&self, low: Vec3, high: Vec3) -> [u32; 3] {
        let [origin, scale] = [self.origin, self.scale].map(|v| v.as_dvec3());
        let [low, high] = [low, high].map(|p| (p.as_dvec3() - origin) * scale);
        let reach = low.abs().max(high.abs()).max_element();
        [0, 1, 2].map(|axis| {
            if self.logarithmic {
                self.logarithmic_word(low[axis], high[axis], reach)
            } else {
                even_word(low[axis], high[axis])
            }
        })
    }

    /// That of an axis on a logarithmic grid, for a box with coordinates up to `reach`.
    fn logarithmic_word(&self, low: f64, high: f64, reach: f64) -> u32 {
        let of_box = FAR_PADDING * reach + self.padding;
        let padding = |x: f64| RELATIVE_PADDING * x.abs() + of_box;
        let high = plane_above(high + padding(high));
        // The plane below x is that above −x, on the other side.
        (plane_above(padding(low) - low) ^ NEGATIVE) | high << 16
    }
}

fn even_word(low: f64, high: f64) -> u32 {
    let low = (low - PADDING).floor().clamp(0.0, CELLS) as u32;
    let high = (high + PADDING).ceil().clamp(0.0, CELLS) as u32;
    low | high << 16
}

/// The word of the lowest plane of the logarithmic grid that is not below `x`.
fn plane_above(x: f64) -> u32 {
    let least = f64::from(f32::from_bits(LOWEST_EXPONENT));
    let magnitude = |x: f64| (x as f32).to_bits().saturating_sub(LOWEST_EXPONENT);
    if x > least {
        let rounded_up = (x as f32).next_up().to_bits() - LOWEST_EXPONENT;
        ((rounded_up + ((1 << SHIFT) - 1)) >> SHIFT).min(NEGATIVE - 1)
    } else if x >= -least {
        0
    } else {
        // Towards 0 is upwards.
        NEGATIVE | magnitude(-x * (1.0 - 1e-7)) >> SHIFT
    }
}
