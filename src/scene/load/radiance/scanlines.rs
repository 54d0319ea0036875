//! Scanlines: red, green, blue and a shared exponent per texel, in runs.

/// What a mantissa is multiplied by: 2^(e − 136), 0 where e is 0.
pub(super) fn scale(exponent: usize) -> f32 {
    if exponent == 0 {
        return 0.0;
    }
    (exponent as f64 - 136.0).exp2() as f32
}

/// What is wrong with a scanline.
pub(super) enum Problem {
    Truncated,
    /// It is as long as this, which is too long.
    RunTooLong(usize),
}

/// Lengths of scanlines that may be encoded by components.
const ENCODED_LENGTHS: std::ops::Range<usize> = 8..0x8000;

/// Decodes a scanline, its first byte the first of `rest`.
pub(super) fn decode_scanline(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> Result<(), Problem> {
    let first = *rest.first_chunk::<4>().ok_or(Problem::Truncated)?;
    let encoded = first[0] == 2 && first[1] == 2 && first[2] < 128;
    if !encoded || !ENCODED_LENGTHS.contains(&scanline.len()) {
        return decode_texels(rest, scanline);
    }
    let length = usize::from(first[2]) << 8 | usize::from(first[3]);
    if length != scanline.len() {
        return Err(Problem::RunTooLong(length));
    }
    *rest = &rest[4..];
    for component in 0..4 {
        decode_component(rest, scanline, component)?;
    }
    Ok(())
}

/// One component of a scanline: runs of one value, 128 + n and the value, and n values as they are.
fn decode_component(
    rest: &mut &[u8],
    scanline: &mut [[u8; 4]],
    component: usize,
) -> Result<(), Problem> {
    let length = scanline.len();
    let mut at = 0;
    while at < length {
        let count = usize::from(take(rest, 1)?[0]);
        let (run, count) = if count > 128 {
            (true, count - 128)
        } else {
            (false, count)
        };
        let texels = scanline.get_mut(at..at + count);
        let texels = texels.ok_or(Problem::RunTooLong(at + count))?;
        let values = take(rest, if run { 1 } else { count })?;
        for (index, texel) in texels.iter_mut().enumerate() {
            texel[component] = values[if run { 0 } else { index }];
        }
        at += count;
    }
    Ok(())
}

/// Texels as they are, with the older runs: (1, 1, 1, n) repeats the texel before n times, further
/// ones of them 256·n times and so on.
fn decode_texels(rest: &mut &[u8], scanline: &mut [[u8; 4]]) -> Result<(), Problem> {
    let length = scanline.len();
    let mut at = 0;
    let mut shift = 0;
    while at < length {
        let texel = *take(rest, 4)?
            .first_chunk::<4>()
            .ok_or(Problem::Truncated)?;
        if texel[..3] != [1, 1, 1] || at == 0 {
            scanline[at] = texel;
            at += 1;
            shift = 0;
            continue;
        }
        let count = usize::from(texel[3]) << shift;
        let before = scanline[at - 1];
        let texels = scanline.get_mut(at..at + count);
        texels.ok_or(Problem::RunTooLong(at + count))?.fill(before);
        at += count;
        shift = (shift + 8).min(24);
    }
    Ok(())
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Problem> {
    let (taken, after) = rest.split_at_checked(count).ok_or(Problem::Truncated)?;
    *rest = after;
    Ok(taken)
}
