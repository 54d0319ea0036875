//! Points of a jittered grid, in random order; integers as on the GPU.

/// A permutation of the numbers up to `mask`, which has all its lower bits set, drawn by `seed`
/// (Kensler 2013, "Correlated Multi-Jittered Sampling", listing 3, for powers of two).
pub fn permute(x: u32, mask: u32, seed: u32) -> u32 {
    let mut y = x ^ seed;
    y = y.wrapping_mul(0xe170_893d);
    y ^= seed >> 16;
    y ^= (y & mask) >> 4;
    y ^= seed >> 8;
    y = y.wrapping_mul(0x0929_eb3f);
    y ^= seed >> 23;
    y ^= (y & mask) >> 1;
    y = y.wrapping_mul(1 | seed >> 27);
    y = y.wrapping_mul(0x6935_fa69);
    y ^= (y & mask) >> 11;
    y = y.wrapping_mul(0x74dc_b303);
    y ^= (y & mask) >> 2;
    y = y.wrapping_mul(0x9e50_1cc3);
    y ^= (y & mask) >> 2;
    y = y.wrapping_mul(0xc860_a3df);
    y &= mask;
    y ^= y >> 5;
    y.wrapping_add(seed) & mask
}

/// A point in one cell of a grid of 2^bits\[0\] × 2^bits\[1\] cells, as fractions of 2³².
pub fn stratified_2d(index: u32, bits: [u32; 2], seed: u32, jitter: [u32; 2]) -> [u32; 2] {
    let cell = permute(index, (1 << (bits[0] + bits[1])) - 1, seed);
    let corner = [cell & ((1 << bits[0]) - 1), cell >> bits[0]];
    std::array::from_fn(|axis| {
        let shifted = corner[axis].checked_shl(32 - bits[axis]).unwrap_or(0);
        shifted | jitter[axis] >> bits[axis]
    })
}
