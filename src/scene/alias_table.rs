//! Choice in constant time from a discrete distribution.
//!
//! Walker 1974; construction by Vose 1991, here in f64 and then rounded to integer thresholds. The
//! probabilities that the table keeps are those it realises, counted over all 2³² random words, not
//! those that were asked for.

/// One entry of an alias table over n entries. Word `u` falls on entry `⌊u·n/2³²⌋`; it stays there
/// when `u·n mod 2³² < threshold`, else it moves to `alias`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AliasEntry {
    /// In units of 2⁻³².
    pub threshold: u32,
    /// The other index.
    pub alias: u32,
}

/// An alias table and the probabilities that it realises.
#[derive(Debug, Clone, PartialEq)]
pub struct AliasTable {
    /// The entries.
    pub entries: Vec<AliasEntry>,
    /// Per index, the exact fraction of the 2³² random words that choose it.
    pub probability: Vec<f64>,
}

/// 2³².
const WORDS: u64 = 1 << 32;

impl AliasTable {
    /// A table for `weights`, which are finite and not negative. An index of weight zero is never
    /// chosen; any other is by one of the 2³² words at least, however small its weight, so that
    /// estimators which divide by the realised probability lose nothing (HARD CASES S2).
    ///
    /// `None` when no weight is positive or there are more than 2³² − 1.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let largest = weights.iter().copied().fold(0.0_f64, f64::max);
        if largest <= 0.0 || !largest.is_finite() || weights.len() as u64 >= WORDS {
            return None;
        }
        // Scaling by the maximum first keeps the sum finite and above zero.
        let sum: f64 = weights.iter().map(|w| w / largest).sum();
        let n = weights.len();
        // The fractions u·n mod 2³² of an entry's words lie n apart: below n units of 2⁻³² there is
        // one of them.
        let one_word = n as f64 / WORDS as f64;
        let mut share: Vec<f64> = weights
            .iter()
            .map(|&w| match w / largest / sum * n as f64 {
                share if w > 0.0 => share.max(one_word),
                _ => 0.0,
            })
            .collect();
        let heaviest = share
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map_or(0, |(i, _)| i as u32);
        let (mut small, mut large): (Vec<u32>, Vec<u32>) =
            (0..n as u32).partition(|&i| share[i as usize] < 1.0);
        let mut entries = vec![
            AliasEntry {
                threshold: u32::MAX,
                alias: 0,
            };
            n
        ];
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            entries[s as usize] = AliasEntry {
                threshold: (share[s as usize] * WORDS as f64).min(f64::from(u32::MAX)) as u32,
                alias: l,
            };
            share[l as usize] = (share[l as usize] + share[s as usize]) - 1.0;
            if share[l as usize] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // What is left has share 1 up to rounding; an index of weight zero goes to the heaviest all
        // the same.
        for i in large.into_iter().chain(small) {
            let zero = weights[i as usize] <= 0.0;
            entries[i as usize] = AliasEntry {
                threshold: if zero { 0 } else { u32::MAX },
                alias: if zero { heaviest } else { i },
            };
        }
        let probability = realised(&entries);
        Some(Self {
            entries,
            probability,
        })
    }

    /// The index that the random word `u` chooses; the same integers as on the GPU.
    pub fn choose(&self, u: u32) -> u32 {
        let product = u64::from(u) * self.entries.len() as u64;
        let index = (product >> 32) as u32;
        let entry = self.entries[index as usize];
        if (product as u32) < entry.threshold {
            index
        } else {
            entry.alias
        }
    }
}

/// Per index, the exact fraction of random words that choose it.
fn realised(entries: &[AliasEntry]) -> Vec<f64> {
    let n = entries.len() as u64;
    let mut words = vec![0_u64; entries.len()];
    for (i, entry) in entries.iter().enumerate() {
        // Words u with ⌊u·n/2³²⌋ = i are first..end; their fractions u·n mod 2³² are start, start +
        // n, ...
        let first = (i as u64 * WORDS).div_ceil(n);
        let end = ((i as u64 + 1) * WORDS).div_ceil(n);
        let start = first * n - i as u64 * WORDS;
        let kept = u64::from(entry.threshold)
            .saturating_sub(start)
            .div_ceil(n)
            .min(end - first);
        words[i] += kept;
        words[entry.alias as usize] += end - first - kept;
    }
    words.iter().map(|&w| w as f64 / WORDS as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_weight_zero_are_never_chosen() {
        let table = AliasTable::new(&[0.0, 1.0, 0.0, 1e30, 1e-30, 0.0]).unwrap();
        for i in [0, 2, 5] {
            assert!(table.probability[i].abs() < f64::MIN_POSITIVE, "index {i}");
        }
        for k in 0..1_u32 << 24 {
            let i = table.choose(k << 8 | 0xff);
            assert!(i != 0 && i != 2 && i != 5, "word {k} chose {i}");
        }
    }

    #[test]
    fn every_positive_weight_has_a_word() {
        let weights: Vec<f64> = (-15..=15).map(|e| 10_f64.powi(e)).collect();
        for n in [31, 1000, 100_000] {
            let weights: Vec<f64> = weights.iter().copied().cycle().take(n).collect();
            let table = AliasTable::new(&weights).unwrap();
            let word = 1.0 / WORDS as f64;
            assert!(table.probability.iter().all(|&p| p >= word));
            let total: f64 = table.probability.iter().sum();
            assert!((total - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn realised_probabilities_are_those_asked_for() {
        let weights: Vec<f64> = (0..1000).map(|i| f64::from(i * i % 97) + 0.25).collect();
        let sum: f64 = weights.iter().sum();
        let table = AliasTable::new(&weights).unwrap();
        let total: f64 = table.probability.iter().sum();
        assert!((total - 1.0).abs() < 1e-15);
        for (w, p) in weights.iter().zip(&table.probability) {
            assert!(
                (w / sum - p).abs() < 1000.0 / WORDS as f64,
                "{} {p}",
                w / sum
            );
        }
    }

    #[test]
    fn realised_probabilities_count_the_words() {
        let table = AliasTable::new(&[0.3, 5.0, 1.7, 0.0, 2.2]).unwrap();
        let mut counted = [0_u64; 5];
        let stride = 1_u32 << 8;
        for k in 0..1_u32 << 24 {
            counted[table.choose(k * stride + 128) as usize] += 1;
        }
        for (c, p) in counted.iter().zip(&table.probability) {
            assert!((*c as f64 / f64::from(1 << 24) - p).abs() < 1e-6);
        }
    }

    #[test]
    fn a_flat_table_is_flat() {
        let table = AliasTable::new(&vec![1.0; 1 << 16]).unwrap();
        assert!(
            table
                .probability
                .iter()
                .all(|&p| (p - (-16_f64).exp2()).abs() < f64::EPSILON)
        );
    }

    #[test]
    fn no_positive_weight_gives_no_table() {
        assert!(AliasTable::new(&[]).is_none());
        assert!(AliasTable::new(&[0.0, 0.0]).is_none());
    }
}
