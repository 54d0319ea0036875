//! The family of statistical tests of the suite: no false alarm in any of them with probability 1 −
//! 1e-4.
//!
//! Every test that rests on chance hands its p-value to [`accept`], and every power test, which a
//! broken twin has to fail, to [`reject`]. When the suite ends, it prints how many there were and
//! the smallest p-value.

use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::broken::BROKEN_TWINS;
use direkt::low_level::stats::sidak::Family;
use direkt::low_level::stats::z_test::z_test;
use std::sync::{Mutex, Once};

/// Tests that the family is declared to have; the level of each follows from it (Šidák).
pub const DECLARED: usize = 4000;

/// What has been tested so far.
#[derive(Debug)]
struct Ledger {
    accepted: usize,
    rejected: usize,
    smallest: f64,
    name: String,
}

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger {
    accepted: 0,
    rejected: 0,
    smallest: 1.0,
    name: String::new(),
});

/// The family.
pub fn family() -> Family {
    Family::new(DECLARED)
}

/// Fails unless `p` is compatible with chance. `what` names function, case, adapter and seed.
pub fn accept(p: f64, what: &str) {
    let rejected = family().rejects(p);
    {
        let mut ledger = entry();
        ledger.accepted += 1;
        assert!(
            ledger.accepted <= DECLARED,
            "more than {DECLARED} statistical tests: declare a larger family"
        );
        if !rejected && p < ledger.smallest {
            ledger.smallest = p;
            ledger.name = what.to_owned();
        }
    }
    assert!(
        !rejected,
        "{what}: p = {p:.3e}, below {:.3e}, the level of one test among {DECLARED}",
        family().test_level()
    );
}

/// Fails unless `p` rejects: the test's power. `what` names the broken twin as well.
pub fn reject(p: f64, what: &str) {
    entry().rejected += 1;
    assert!(
        family().rejects(p),
        "{what}: the broken twin passes with p = {p:.3e}"
    );
}

/// Rejects the p-value that each broken twin gets from `p_value`, which is `None` where the mistake
/// does not concern what is tested. One of them has to concern it.
pub fn reject_broken(what: &str, p_value: impl Fn(BrokenTwin) -> Option<f64>) {
    let mut concerned = false;
    for row in BROKEN_TWINS {
        if let Some(p) = p_value(row.twin) {
            concerned = true;
            reject(p, &format!("{what}, {}", row.name));
        }
    }
    assert!(concerned, "{what}: no broken twin to reject");
}

/// p-value of the hypothesis that pairs of uniform numbers of [0, 1) are independent: under it the
/// mean of (a − ½)(b − ½) over N pairs has the variance 1/(144 N). The longer slice's rest is left
/// out.
pub fn correlation_p_value(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len()) as f64;
    let products = a.iter().zip(b).map(|(a, b)| (a - 0.5) * (b - 0.5));
    z_test(products.sum::<f64>() / n, 0.0, 1.0 / (144.0 * n), 0.0).p_value
}

fn entry() -> std::sync::MutexGuard<'static, Ledger> {
    static AT_EXIT: Once = Once::new();
    AT_EXIT.call_once(|| super::at_exit(summary));
    LEDGER
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

extern "C" fn summary() {
    let ledger = LEDGER
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let _ = std::io::Write::write_fmt(
        &mut std::io::stderr(),
        format_args!(
            "\nstatistical tests: {} (declared {DECLARED}, family-wise level {:.0e}, each {:.2e}), smallest p-value {:.2e} ({}); broken twins rejected: {}\n",
            ledger.accepted,
            family().level,
            family().test_level(),
            ledger.smallest,
            ledger.name,
            ledger.rejected,
        ),
    );
}
