//! Numbers that are not ordinary ones, and the order of operations.

use super::probe::probe;
use crate::error::GpuError;
use crate::gpu::Context;
use serde::Serialize;

/// What a driver does to numbers. WGSL leaves it free in all of this but the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Arithmetic {
    /// NaNs, infinities and finite numbers that their bits do not tell: direkt's ledger rests on
    /// them.
    pub misclassified: u32,
    /// Such that comparisons (`x != x`, `x > 3.4e38`) do not tell.
    pub misclassified_by_comparison: u32,
    /// NaNs that pass a test for the range of finite numbers (`x < −3.4e38 || x > 3.4e38` is
    /// false).
    pub passed_by_range: u32,
    /// Whether subnormal numbers stay what they are.
    pub keeps_subnormals: bool,
    /// Whether a product and a sum are fused although nothing says so.
    pub contracts: bool,
    /// Whether `fma` rounds once.
    pub fuses_fma: bool,
    /// Whether the error term of a compensated sum is computed.
    pub keeps_compensation: bool,
}

/// What the bits of a float are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Finite,
    Nan,
    Infinite,
}

/// Bits and what they are. The first is one, the second (1 + 2⁻¹²)² rounded.
const QUESTIONS: [(u32, Kind); 16] = [
    (0x3f80_0000, Kind::Finite),
    (0x3f80_1000, Kind::Finite),
    (0x0000_0000, Kind::Finite),
    (0x8000_0000, Kind::Finite),
    (0x0000_0001, Kind::Finite),
    (0x807f_ffff, Kind::Finite),
    (0x0080_0000, Kind::Finite),
    (0x7f7f_ffff, Kind::Finite),
    (0xff7f_ffff, Kind::Finite),
    (0x7f80_0000, Kind::Infinite),
    (0xff80_0000, Kind::Infinite),
    (0x7f80_0001, Kind::Nan),
    (0x7fc0_0000, Kind::Nan),
    (0x7fff_ffff, Kind::Nan),
    (0xff80_0001, Kind::Nan),
    (0xffc0_0000, Kind::Nan),
];

/// Asks `shaders/kernel/arithmetic.wesl`.
///
/// # Errors
/// The kernel does not compile or the driver fails.
pub fn arithmetic(context: &Context) -> Result<Arithmetic, GpuError> {
    let bits = QUESTIONS.map(|(bits, _)| bits);
    let words = probe(context, "arithmetic", &bits, 8 * bits.len(), [1, 1])?;
    let answers = || QUESTIONS.iter().zip(words.chunks_exact(8));
    let kind = |nan: u32, infinite: u32| match (nan, infinite) {
        (0, 0) => Kind::Finite,
        (1, _) => Kind::Nan,
        _ => Kind::Infinite,
    };
    let count = |wrong: &dyn Fn(Kind, &[u32]) -> bool| {
        answers().filter(|((_, is), w)| wrong(*is, w)).count() as u32
    };
    let subnormal = |bits: u32| bits << 1 != 0 && bits & 0x7f80_0000 == 0;
    let mut subnormals = answers().filter(|((bits, _), _)| subnormal(*bits));
    Ok(Arithmetic {
        misclassified: count(&|is, w| kind(w[0], w[1]) != is),
        misclassified_by_comparison: count(&|is, w| kind(w[2], w[3]) != is),
        passed_by_range: count(&|is, w| is == Kind::Nan && w[3] == 0),
        keeps_subnormals: subnormals.all(|((bits, _), w)| w[4] == *bits),
        contracts: words[5] << 1 != 0,
        fuses_fma: words[6] << 1 != 0,
        keeps_compensation: words[7] << 1 != 0,
    })
}
