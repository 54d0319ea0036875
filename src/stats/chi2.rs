//! Pearson's χ² test of counts against what a distribution expects.

use statrs::function::gamma::gamma_ur;

/// Fewest expected counts in a cell that the χ² distribution is taken to hold for (Cochran 1952).
pub const MIN_EXPECTED: f64 = 5.0;

/// How the number of samples came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Totals {
    /// It was fixed, and the expected counts share it out: their sum equals that of the observed
    /// counts. One degree of freedom is lost.
    Tied,
    /// Every cell's count is Poisson distributed by itself. No degree of freedom is lost.
    Free,
}

/// The result of a χ² test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chi2 {
    /// Σ (observed − expected)²/expected over the cells after pooling; infinite after a hit in an
    /// impossible cell.
    pub statistic: f64,
    /// Cells after pooling, less one when the totals are tied.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic at least as large when the counts follow what is expected.
    pub p_value: f64,
}

/// Why counts cannot be tested.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Chi2Error {
    /// The slices have different lengths.
    #[error("{observed} observed cells, {expected} expected ones: give as many")]
    Lengths {
        /// Cells observed.
        observed: usize,
        /// Cells expected.
        expected: usize,
    },
    /// An expected count is negative or not finite.
    #[error("cell {cell} expects {expected}: an expected count is finite and not negative")]
    Expected {
        /// Index of the cell.
        cell: usize,
        /// Its expected count.
        expected: f64,
    },
    /// The totals should be tied and are not: a density that does not integrate to one, or samples
    /// that fell beside all cells.
    #[error("{observed} counts in all, {expected} expected: tied totals are equal")]
    Totals {
        /// Sum of the observed counts.
        observed: f64,
        /// Sum of the expected counts.
        expected: f64,
    },
    /// No degree of freedom is left, so nothing could be rejected.
    #[error("too few cells expect {MIN_EXPECTED} counts: draw more samples")]
    NothingToTest,
}

/// Relative difference up to which tied totals count as equal; expected counts are integrals of a
/// density.
const TOTALS_TOLERANCE: f64 = 1e-6;

/// Tests whether `observed` counts follow the `expected` ones.
///
/// Cells that expect fewer than [`MIN_EXPECTED`] are pooled, the smallest first, until a pool
/// reaches it; what is left at the end joins the last pool, or else the smallest cell. The pools
/// depend on the expected counts alone (and on the index where these are equal), never on what was
/// observed. A hit in a cell that expects zero has p-value 0.
///
/// # Errors
///
/// When the cells do not match, an expected count is not a number of counts, tied totals differ by
/// more than 10⁻⁶, or no degree of freedom is left.
pub fn chi2_test(observed: &[u64], expected: &[f64], totals: Totals) -> Result<Chi2, Chi2Error> {
    validate(observed, expected, totals)?;
    let mut cells: Vec<(f64, f64)> = Vec::new();
    for (&o, &e) in observed.iter().zip(expected) {
        if e > 0.0 {
            cells.push((e, o as f64));
        } else if o > 0 {
            return Ok(Chi2 {
                statistic: f64::INFINITY,
                degrees_of_freedom: 0,
                p_value: 0.0,
            });
        }
    }
    let cells = pool(cells);
    let degrees_of_freedom = cells
        .len()
        .saturating_sub(usize::from(totals == Totals::Tied));
    if degrees_of_freedom == 0 || cells.iter().any(|&(e, _)| e < MIN_EXPECTED) {
        return Err(Chi2Error::NothingToTest);
    }
    let statistic: f64 = cells.iter().map(|&(e, o)| (o - e) * (o - e) / e).sum();
    // P(χ²_k ≥ s) = Q(k/2, s/2), the regularised upper incomplete gamma function.
    let p_value = if statistic > 0.0 {
        gamma_ur(degrees_of_freedom as f64 / 2.0, statistic / 2.0)
    } else {
        1.0
    };
    Ok(Chi2 {
        statistic,
        degrees_of_freedom,
        p_value,
    })
}

fn validate(observed: &[u64], expected: &[f64], totals: Totals) -> Result<(), Chi2Error> {
    if observed.len() != expected.len() {
        return Err(Chi2Error::Lengths {
            observed: observed.len(),
            expected: expected.len(),
        });
    }
    if let Some(cell) = expected.iter().position(|e| !e.is_finite() || *e < 0.0) {
        return Err(Chi2Error::Expected {
            cell,
            expected: expected[cell],
        });
    }
    let (all, due) = (
        observed.iter().sum::<u64>() as f64,
        expected.iter().sum::<f64>(),
    );
    if totals == Totals::Tied && (all - due).abs() > TOTALS_TOLERANCE * all.max(due) {
        return Err(Chi2Error::Totals {
            observed: all,
            expected: due,
        });
    }
    Ok(())
}

/// Pools cells (expected, observed) as [`chi2_test`] says.
fn pool(mut cells: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    // Stable, so equal expectations stay in the order of their index.
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first_large = cells.partition_point(|c| c.0 < MIN_EXPECTED);
    let mut large = cells.split_off(first_large);
    let mut pools: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (e, o) in cells {
        open = (open.0 + e, open.1 + o);
        if open.0 >= MIN_EXPECTED {
            pools.push(std::mem::take(&mut open));
        }
    }
    if open.0 > 0.0 {
        if let Some(last) = pools.last_mut().or(large.first_mut()) {
            *last = (last.0 + open.0, last.1 + open.1);
        } else {
            pools.push(open);
        }
    }
    pools.append(&mut large);
    pools
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Stream, assert_rejects_at_its_rate};
    use super::*;

    /// Counts of `n` samples of a discrete distribution.
    fn draw(stream: &mut Stream, probability: &[f64], n: u32) -> Vec<u64> {
        let mut counts = vec![0; probability.len()];
        for _ in 0..n {
            let mut u = stream.uniform();
            let chosen = probability.iter().position(|p| {
                u -= p;
                u < 0.0
            });
            counts[chosen.unwrap_or(probability.len() - 1)] += 1;
        }
        counts
    }

    fn scale(probability: &[f64], n: f64) -> Vec<f64> {
        probability.iter().map(|p| p * n).collect()
    }

    #[test]
    fn p_values_are_those_of_the_tables() {
        // χ²(0.95; 1) = 3.841458820694124, χ²(0.999; 10) = 29.58829844507442 (Abramowitz & Stegun,
        // table 26.8).
        let offset = (3.841_458_820_694_124_f64 * 1e6 / 2.0).sqrt();
        let observed = [(1e6 + offset).round() as u64, (1e6 - offset).round() as u64];
        let result = chi2_test(&observed, &[1e6, 1e6], Totals::Tied).unwrap();
        assert_eq!(result.degrees_of_freedom, 1);
        // The counts are rounded by up to ½ of 1386, so the statistic by 0.0028; the density there
        // is 0.030.
        assert!((result.p_value - 0.05).abs() < 1e-4);
        assert!((gamma_ur(5.0, 29.588_298_445_074_42 / 2.0) - 1e-3).abs() < 1e-12);
    }

    #[test]
    fn it_rejects_at_its_rate() {
        // Six cells that expect 30 or more each: taken to hold to a tenth of the 1 %.
        let probability = [0.1, 0.2, 0.3, 0.15, 0.15, 0.1];
        assert_rejects_at_its_rate(20.0, |stream| {
            let observed = draw(stream, &probability, 300);
            let expected = scale(&probability, 300.0);
            chi2_test(&observed, &expected, Totals::Tied)
                .unwrap()
                .p_value
        });
    }

    #[test]
    fn a_two_percent_effect_is_rejected() {
        // One of 8 cells has 2 % too much: non-centrality n·(0.02²/8 + 7·(0.02/7)²/8) = 57 n/10⁶ =
        // 228 for 4·10⁶ samples, far above 1e-6's critical value of 40 plus its own spread √(2(7 +
        // 2·228)) = 30.
        let n = 4_000_000_u32;
        let flat = [0.125; 8];
        let mut bent = [0.125 * (1.0 - 0.02 / 7.0); 8];
        bent[3] = 0.125 * 1.02;
        let mut stream = Stream::new(2);
        let observed = draw(&mut stream, &bent, n);
        let p_of = |p: &[f64]| {
            chi2_test(&observed, &scale(p, f64::from(n)), Totals::Tied)
                .unwrap()
                .p_value
        };
        assert!(p_of(&flat) < 1e-6);
        assert!(p_of(&bent) > 1e-6);
    }

    #[test]
    fn pools_do_not_depend_on_the_order_of_the_cells() {
        let expected = [0.5, 40.0, 2.0, 3.0, 0.1, 7.0, 1.9, 4.5, 0.7, 11.0, 0.2];
        let observed = [1, 38, 3, 2, 0, 9, 1, 5, 1, 10, 0];
        let mut order: Vec<usize> = (0..expected.len()).collect();
        let due: f64 = expected.iter().sum();
        assert!((due - 70.9).abs() < 1e-12);
        let first = chi2_test(&observed, &expected, Totals::Free).unwrap();
        // 0.1 0.2 0.5 0.7 1.9 2.0 | 3.0 4.5 | 7 | 11 | 40.
        assert_eq!(first.degrees_of_freedom, 5);
        for _ in 0..expected.len() {
            order.rotate_left(3);
            order.swap(0, 7);
            let e: Vec<f64> = order.iter().map(|&i| expected[i]).collect();
            let o: Vec<u64> = order.iter().map(|&i| observed[i]).collect();
            let again = chi2_test(&o, &e, Totals::Free).unwrap();
            assert!((again.statistic - first.statistic).abs() < 1e-12);
        }
    }

    #[test]
    fn a_remainder_joins_a_pool() {
        let pools = pool(vec![(4.0, 1.0), (3.0, 2.0), (2.0, 3.0), (9.0, 9.0)]);
        // 2 + 3 reach 5, the 4 that is left joins them.
        assert_eq!(pools, vec![(9.0, 6.0), (9.0, 9.0)]);
        assert_eq!(pool(vec![(1.0, 1.0), (6.0, 5.0)]), vec![(7.0, 6.0)]);
    }

    #[test]
    fn an_impossible_hit_is_rejected_outright() {
        let hit = chi2_test(&[50, 50, 1], &[50.5, 50.5, 0.0], Totals::Tied).unwrap();
        assert!(hit.p_value <= 0.0);
        let none = chi2_test(&[50, 50, 0], &[50.0, 50.0, 0.0], Totals::Tied).unwrap();
        assert_eq!(none.degrees_of_freedom, 1);
        assert!(none.p_value >= 1.0);
    }

    #[test]
    fn what_cannot_be_tested_is_an_error() {
        let test = |o: &[u64], e: &[f64]| chi2_test(o, e, Totals::Tied).unwrap_err();
        assert!(matches!(test(&[1], &[1.0, 2.0]), Chi2Error::Lengths { .. }));
        assert!(matches!(
            test(&[9, 9], &[9.0, f64::NAN]),
            Chi2Error::Expected { cell: 1, .. }
        ));
        assert!(matches!(
            test(&[9, 9], &[9.0, 8.0]),
            Chi2Error::Totals { .. }
        ));
        assert_eq!(test(&[1, 1], &[1.0, 1.0]), Chi2Error::NothingToTest);
        assert_eq!(test(&[100], &[100.0]), Chi2Error::NothingToTest);
    }
}
