//! Errors of elementary functions against f64.

use super::probe::probe;
use crate::error::GpuError;
use crate::gpu::Context;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Arguments of each function.
const COUNT: usize = 1 << 16;

/// The worst error of a function.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Precision {
    /// The function.
    pub function: &'static str,
    /// Where it was asked.
    pub domain: &'static str,
    /// Largest error in units in the last place of the exact value.
    pub ulp: f64,
    /// Largest absolute error.
    pub absolute: f64,
    /// What WGSL grants, or direkt's own functions promise.
    pub allowed: Allowed,
    /// Whether direkt's images rest on it.
    pub needed: bool,
}

/// A bound on an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Allowed {
    /// Units in the last place.
    Ulp(f64),
    /// Absolute.
    Absolute(f64),
}

impl Precision {
    /// Whether the error is within what is allowed.
    pub fn is_within(&self) -> bool {
        match self.allowed {
            Allowed::Ulp(bound) => self.ulp <= bound,
            Allowed::Absolute(bound) => self.absolute <= bound,
        }
    }

    /// The error, in words.
    pub fn worst(&self) -> String {
        match self.allowed {
            Allowed::Ulp(_) => format!("{:.2} ulp", self.ulp),
            Allowed::Absolute(_) => format!("{:.1e}", self.absolute),
        }
    }

    /// What is allowed, in words.
    pub fn bound(&self) -> String {
        match self.allowed {
            Allowed::Ulp(bound) => format!("{bound} ulp"),
            Allowed::Absolute(bound) => format!("{bound:.1e}"),
        }
    }
}

/// A function: its name and domain, how two numbers of [0, 1) become its arguments, what is exact
/// and allowed, and whether images rest on it.
struct Function {
    name: &'static str,
    domain: &'static str,
    arguments: fn(f64, f64) -> [f64; 2],
    exact: fn(f64, f64) -> f64,
    allowed: Allowed,
    needed: bool,
}

/// In the order of `shaders/kernel/elementary.wesl`. Bounds of the driver's own functions are
/// WGSL's (section 15.7.4, accuracy of built-in functions), of direkt's those that
/// `shaders/core/math.wesl` states.
const FUNCTIONS: [Function; 12] = [
    Function {
        name: "division",
        domain: "2^±60",
        arguments: |u, v| [signed_magnitude(u), signed_magnitude(v)],
        exact: |x, y| x / y,
        allowed: Allowed::Ulp(2.5),
        needed: true,
    },
    Function {
        name: "sqrt",
        domain: "2^±120",
        arguments: |u, _| [magnitude(u, 120.0), 0.0],
        exact: |x, _| x.sqrt(),
        // 1/inverseSqrt(x): 2 ulp, and 2.5 of the quotient.
        allowed: Allowed::Ulp(4.5),
        needed: true,
    },
    Function {
        name: "inverseSqrt",
        domain: "2^±120",
        arguments: |u, _| [magnitude(u, 120.0), 0.0],
        exact: |x, _| x.sqrt().recip(),
        allowed: Allowed::Ulp(2.0),
        needed: true,
    },
    Function {
        name: "sin",
        domain: "[−π, π]",
        arguments: |u, _| [PI * (2.0 * u - 1.0), 0.0],
        exact: |x, _| x.sin(),
        allowed: Allowed::Absolute(1.0 / 2048.0),
        needed: false,
    },
    Function {
        name: "cos",
        domain: "[−π, π]",
        arguments: |u, _| [PI * (2.0 * u - 1.0), 0.0],
        exact: |x, _| x.cos(),
        allowed: Allowed::Absolute(1.0 / 2048.0),
        needed: false,
    },
    Function {
        name: "acos",
        domain: "[−1, 1]",
        arguments: |u, _| [2.0 * u - 1.0, 0.0],
        exact: |x, _| x.acos(),
        // 6.77e-5, or what follows from atan2's 4096 ulp of π.
        allowed: Allowed::Absolute(4096.0 * PI / 8_388_608.0),
        needed: false,
    },
    Function {
        name: "atan2",
        domain: "2^±60",
        arguments: |u, v| [signed_magnitude(u), signed_magnitude(v)],
        exact: f64::atan2,
        allowed: Allowed::Ulp(4096.0),
        needed: false,
    },
    Function {
        name: "exp",
        domain: "[−80, 80]",
        arguments: |u, _| [160.0 * u - 80.0, 0.0],
        exact: |x, _| x.exp(),
        // 3 + 2·|x| ulp.
        allowed: Allowed::Ulp(163.0),
        needed: false,
    },
    Function {
        name: "log",
        domain: "2^1 to 2^100",
        arguments: |u, _| [2.0 * (99.0 * u).exp2(), 0.0],
        exact: |x, _| x.ln(),
        allowed: Allowed::Ulp(3.0),
        needed: false,
    },
    Function {
        name: "direkt's sin(2πu)",
        domain: "[0, 1)",
        arguments: |u, _| [u, 0.0],
        exact: |u, _| (TAU * u).sin(),
        allowed: Allowed::Absolute(4.0 / 16_777_216.0),
        needed: true,
    },
    Function {
        name: "direkt's cos(2πu)",
        domain: "[0, 1)",
        arguments: |u, _| [u, 0.0],
        exact: |u, _| (TAU * u).cos(),
        allowed: Allowed::Absolute(4.0 / 16_777_216.0),
        needed: true,
    },
    Function {
        name: "direkt's angle_of",
        domain: "2^±60",
        arguments: |u, v| [signed_magnitude(u), signed_magnitude(v)],
        exact: f64::atan2,
        allowed: Allowed::Absolute(7e-7),
        needed: true,
    },
];

/// With a uniform logarithm, up to 2^±`exponent`.
fn magnitude(u: f64, exponent: f64) -> f64 {
    (exponent * (2.0 * u - 1.0)).exp2()
}

/// The same up to 2^±60, with either sign.
fn signed_magnitude(u: f64) -> f64 {
    let half = 2.0 * u;
    if half < 1.0 {
        magnitude(half, 60.0)
    } else {
        -magnitude(half - 1.0, 60.0)
    }
}

/// Point `i` of a sequence that fills the unit square evenly: multiples of the powers of the
/// plastic number (Roberts 2018).
fn point(i: usize) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let i = i as f64 + 0.5;
    [i / PLASTIC, i / (PLASTIC * PLASTIC)].map(f64::fract)
}

/// Asks `shaders/kernel/elementary.wesl`.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub fn sweep(context: &Context) -> Result<Vec<Precision>, GpuError> {
    let arguments = |f: &Function| -> Vec<[f32; 2]> {
        let at = |i| {
            let [u, v] = point(i);
            (f.arguments)(u, v).map(|x| x as f32)
        };
        (0..COUNT).map(at).collect()
    };
    let questions: Vec<Vec<[f32; 2]>> = FUNCTIONS.iter().map(arguments).collect();
    let words: &[f32] = &questions.concat().concat();
    let groups = [COUNT as u32 / 64, FUNCTIONS.len() as u32];
    let outputs = COUNT * FUNCTIONS.len();
    let answers = probe(
        context,
        "elementary",
        bytemuck::cast_slice(words),
        outputs,
        groups,
    )?;
    let asked = FUNCTIONS.iter().zip(&questions);
    let results = asked.zip(answers.chunks_exact(COUNT));
    Ok(results
        .map(|((function, questions), answers)| worst(function, questions, answers))
        .collect())
}

fn worst(function: &Function, questions: &[[f32; 2]], answers: &[u32]) -> Precision {
    let (mut ulp, mut absolute) = (0.0_f64, 0.0_f64);
    for (&[x, y], &bits) in questions.iter().zip(answers) {
        let exact = (function.exact)(f64::from(x), f64::from(y));
        let found = f64::from(f32::from_bits(bits));
        // A NaN is as wrong as can be.
        let off = (found - exact).abs();
        let off = if off.is_nan() { f64::INFINITY } else { off };
        absolute = absolute.max(off);
        ulp = ulp.max(off / unit_in_the_last_place(exact));
    }
    Precision {
        function: function.name,
        domain: function.domain,
        ulp,
        absolute,
        allowed: function.allowed,
        needed: function.needed,
    }
}

/// Distance of the f32s around `x`.
fn unit_in_the_last_place(x: f64) -> f64 {
    let exponent = x.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor();
    (exponent - 23.0).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_f32() {
        for x in [1.0_f32, 1.5, 2.0, 3e-20, 7e30] {
            let next = f32::from_bits(x.to_bits() + 1);
            let unit = unit_in_the_last_place(f64::from(x));
            assert!((f64::from(next - x) / unit - 1.0).abs() < 1e-6, "{x}");
        }
        assert!(unit_in_the_last_place(0.0) > 0.0);
    }

    #[test]
    fn wrong_answers_are_seen() {
        let division = &FUNCTIONS[0];
        let questions = [[1.0, 3.0], [2.0, 5.0]];
        let right = questions.map(|[x, y]: [f32; 2]| (x / y).to_bits());
        let found = worst(division, &questions, &right);
        assert!(found.ulp <= 0.5 && found.is_within());
        let off = worst(division, &questions, &[right[0] + 3, right[1]]);
        assert!(off.ulp > 2.5 && !off.is_within(), "{off:?}");
        let nan = worst(division, &questions, &[right[0], f32::NAN.to_bits()]);
        assert!(!nan.is_within());
    }
}
