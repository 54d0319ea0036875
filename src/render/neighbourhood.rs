//! Means over the pixels around each pixel.

use crate::scene::FilmSize;
use rayon::prelude::*;

/// Per pixel and value the mean over the square of pixels at most `radius` away, as far as it
/// lies in the image.
pub(crate) fn box_mean<const N: usize>(
    values: &[[f64; N]],
    size: FilmSize,
    radius: usize,
) -> Vec<[f64; N]> {
    let (width, height) = (size.width as usize, size.height as usize);
    let mut rows = vec![[0.0; N]; values.len()];
    rows.par_chunks_mut(width)
        .zip(values.par_chunks(width))
        .for_each(|(out, row)| {
            for (x, out) in out.iter_mut().enumerate() {
                *out = mean(&row[x.saturating_sub(radius)..(x + radius + 1).min(width)]);
            }
        });
    let mut means = vec![[0.0; N]; values.len()];
    means
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, out)| {
            let around = y.saturating_sub(radius)..(y + radius + 1).min(height);
            let part = 1.0 / around.len() as f64;
            for y in around {
                for (out, value) in out.iter_mut().zip(&rows[y * width..]) {
                    for c in 0..N {
                        out[c] += value[c] * part;
                    }
                }
            }
        });
    means
}

/// The same without the pixel itself, from the `means` with it; zero where there are no others.
pub(crate) fn mean_of_others<const N: usize>(
    means: &[[f64; N]],
    values: &[[f64; N]],
    size: FilmSize,
    radius: usize,
) -> Vec<[f64; N]> {
    let (width, height) = (size.width as usize, size.height as usize);
    let side = |at: usize, length: usize| (at + radius + 1).min(length) - at.saturating_sub(radius);
    let pixels = means.par_iter().zip(values).enumerate();
    let others = pixels.map(|(i, (mean, value))| {
        let count = (side(i % width, width) * side(i / width, height)) as f64;
        std::array::from_fn(|c| (count * mean[c] - value[c]) / (count - 1.0).max(1.0))
    });
    others.collect()
}

fn mean<const N: usize>(values: &[[f64; N]]) -> [f64; N] {
    let sum = values
        .iter()
        .fold([0.0; N], |sum, v| std::array::from_fn(|c| sum[c] + v[c]));
    sum.map(|s| s / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_take_what_lies_in_the_image() {
        let size = FilmSize {
            width: 4,
            height: 3,
        };
        let values: Vec<[f64; 3]> = (0..12).map(|i| [f64::from(i), 1.0, 0.0]).collect();
        let means = box_mean(&values, size, 1);
        // Around (0, 0): 0, 1, 4, 5; around (2, 1): 1 to 3, 5 to 7, 9 to 11.
        assert!((means[0][0] - 2.5).abs() < 1e-12);
        assert!((means[6][0] - 6.0).abs() < 1e-12);
        assert!(means.iter().all(|m| (m[1] - 1.0).abs() < 1e-12));
        let others = mean_of_others(&means, &values, size, 1);
        assert!((others[0][0] - 10.0 / 3.0).abs() < 1e-12);
        assert!((others[6][0] - 6.0).abs() < 1e-12);
        let one = FilmSize {
            width: 1,
            height: 1,
        };
        let alone = [[3.0, 1.0, 0.0]];
        assert_eq!(mean_of_others(&alone, &alone, one, 2), [[0.0; 3]]);
        let all = box_mean(&values, size, 9);
        assert!(all.iter().all(|m| (m[0] - 5.5).abs() < 1e-12));
    }
}
