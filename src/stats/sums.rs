//! Sums that are taken in parallel and have the same bits each time.

use rayon::prelude::*;

/// Values that are added one after the other.
const CHUNK: usize = 4096;

/// The sum of `values`, component by component: in pieces of a fixed length, whose sums are added
/// in their order, so that the number of threads makes no difference.
pub(crate) fn sum<const N: usize>(
    values: impl IndexedParallelIterator<Item = [f64; N]>,
) -> [f64; N] {
    let add = |a: [f64; N], b: [f64; N]| std::array::from_fn(|i| a[i] + b[i]);
    let pieces = values.fold_chunks(CHUNK, || [0.0; N], add);
    pieces.collect::<Vec<_>>().into_iter().fold([0.0; N], add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_do_not_depend_on_the_threads() {
        let values: Vec<[f64; 2]> = (1..50_000)
            .map(|i| [1.0 / f64::from(i), f64::from(i)])
            .collect();
        let expected = sum(values.par_iter().copied());
        assert!((expected[1] - 1_249_975_000.0).abs() < 1e-3);
        for threads in [1, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let found = pool
                .build()
                .expect("threads")
                .install(|| sum(values.par_iter().copied()));
            assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits));
        }
    }
}
