//! Colours of relative errors.

/// Relative errors at the ends of the heat map's colours.
pub const HEAT: (f64, f64) = (0.003, 1.0);

/// Colours of the heat map, from small errors to large: dark, violet, red, yellow, white. Their
/// luminance rises throughout.
const RAMP: [[f64; 3]; 7] = [
    [0.0, 0.0, 4.0],
    [40.0, 11.0, 84.0],
    [101.0, 21.0, 110.0],
    [159.0, 42.0, 99.0],
    [212.0, 72.0, 66.0],
    [245.0, 125.0, 21.0],
    [252.0, 255.0, 164.0],
];

/// 8-bit colour of a relative error.
pub fn heat(error: f64) -> [u8; 3] {
    let (low, high) = HEAT;
    ramp((error.max(low) / low).ln() / (high / low).ln())
}

/// 8-bit colour of a `part` of the ramp, from 0, dark, to 1, light.
pub fn ramp(part: f64) -> [u8; 3] {
    let x = part.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let i = (x as usize).min(RAMP.len() - 2);
    let t = x - i as f64;
    [0, 1, 2].map(|c| (RAMP[i][c] + t * (RAMP[i + 1][c] - RAMP[i][c])).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_errors_are_lighter() {
        let luminance = |e: f64| {
            let [r, g, b] = heat(e).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let steps: Vec<_> = (0..50).map(|i| 0.003 * 1.13_f64.powi(i)).collect();
        let steps = steps.windows(2).filter(|w| w[1] < 1.0);
        assert!(steps.into_iter().all(|w| luminance(w[0]) < luminance(w[1])));
        assert_eq!(heat(0.0), [0, 0, 4]);
        assert_eq!(heat(7.0), [252, 255, 164]);
    }
}
