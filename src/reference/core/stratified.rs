//! Points of a jittered grid, in random order; integers as on the GPU.

use super::sobol::scramble_reversed;

/// A point in one cell of a grid of 2^bits\[0\] × 2^bits\[1\] cells, as fractions of 2³².
pub fn stratified_2d(index: u32, bits: [u32; 2], seed: u32, jitter: [u32; 2]) -> [u32; 2] {
    let cell = scramble_reversed(index, seed) & ((1 << (bits[0] + bits[1])) - 1);
    let corner = [cell & ((1 << bits[0]) - 1), cell >> bits[0]];
    std::array::from_fn(|axis| {
        let shifted = corner[axis].checked_shl(32 - bits[axis]).unwrap_or(0);
        shifted | jitter[axis] >> bits[axis]
    })
}
