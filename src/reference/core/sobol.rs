//! The first two dimensions of Sobol's sequence with Owen's scrambling; integers as on the GPU.

/// Sobol's second dimension with its bits reversed, from its direction numbers v_k = v_{k−1} ⊕
/// (v_{k−1} ≫ 1) (Sobol' 1967), where the shader applies Pascal's triangle in logarithmic steps.
pub fn sobol_second_reversed(index: u32) -> u32 {
    let mut direction = 1_u32 << 31;
    let mut x = 0;
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            x ^= direction;
        }
        direction ^= direction >> 1;
    }
    x.reverse_bits()
}

/// Owen's nested uniform scrambling of a number with its bits reversed (Laine & Karras 2011;
/// constants by Vegdahl 2021).
pub fn scramble_reversed(x: u32, seed: u32) -> u32 {
    let mut y = x;
    y ^= y.wrapping_mul(0x3d20_adea);
    y = y.wrapping_add(seed);
    y = y.wrapping_mul((seed >> 16) | 1);
    y ^= y.wrapping_mul(0x0552_6c56);
    y ^ y.wrapping_mul(0x53a2_2864)
}

/// Point `index` of a scrambled and shuffled two-dimensional Sobol sequence, as fractions of 2³²
/// (Burley 2020).
pub fn sobol_2d(index: u32, [shuffle, first, second]: [u32; 3]) -> [u32; 2] {
    let shuffled = scramble_reversed(index.reverse_bits(), shuffle).reverse_bits();
    [
        scramble_reversed(shuffled, first).reverse_bits(),
        scramble_reversed(sobol_second_reversed(shuffled), second).reverse_bits(),
    ]
}
