//! Lattices by the golden section, whose multiples are spread evenly, as many or few of them as are
//! taken.

/// The golden section of 1.
const SECTION: f64 = 0.618_033_988_749_894_8;

/// The number without a factor in common with `n` that is nearest to the golden section of it; 0
/// for 0 and 1.
///
/// Its first `n` multiples modulo `n` are all numbers below `n`, each once.
pub(crate) fn coprime(n: u32) -> u32 {
    let golden = f64::from(n) * SECTION;
    let coprime = |k: &u32| gcd(*k, n) == 1;
    let distance = |k: &u32| (f64::from(*k) - golden).abs();
    let below = (1..=golden as u32).rev().find(coprime);
    let above = (golden as u32 + 1..n).find(coprime);
    let nearest = below.into_iter().chain(above);
    let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.unwrap_or(0)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_are_all_numbers_and_no_coprime_is_nearer() {
        for n in 0..300 {
            let generator = coprime(n);
            let mut taken: Vec<_> = (0..n).map(|i| i * generator % n).collect();
            taken.sort_unstable();
            assert_eq!(taken, Vec::from_iter(0..n), "{n}");
            let distance = |k: u32| (f64::from(k) - SECTION * f64::from(n)).abs();
            let mut others = (1..n).filter(|&k| gcd(k, n) == 1);
            assert!(others.all(|k| distance(k) >= distance(generator)), "{n}");
        }
    }
}
