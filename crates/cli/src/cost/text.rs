//! What `direkt cost` prints.

use direkt_instruments::cost::{Interval, SceneCost};
use direkt_instruments::report::format::{agreement, number, range, seconds, short, slope};
use direkt_instruments::report::{self, with_effects};

/// The table of all estimators, what unneeded effects cost, and who cannot be used.
pub fn summary(cost: &SceneCost) -> String {
    let mut out = format!(
        "{}: {} × {}, {:.1} s of rendering\n  rank  {:<40}{:>34}{:>12}{:>16}{:>12}\n",
        cost.scene,
        cost.width,
        cost.height,
        cost.seconds,
        "estimator",
        "efficiency 1/(relMSE·s)",
        "per sample",
        "slope",
        format!("to {}", short(cost.target)),
    );
    for e in report::ranked(cost) {
        let interval = e.efficiency;
        let efficiency = format!("{} {}", number(interval.value), range(&interval, number));
        let slope = slope(e.slope_samples);
        let reached = e.reached.iter();
        let reached = reached.filter(|r| (r.target / cost.target - 1.0).abs() < 1e-9);
        let reached = reached.map(|r| r.seconds.value).next();
        out.push_str(&format!(
            "  {:>3}{}  {:<40}{efficiency:>34}{:>12}{slope:>16}{:>12}\n",
            e.rank.rank,
            if e.rank.ties.is_empty() { " " } else { "=" },
            e.name,
            seconds(e.seconds_per_sample.value),
            reached.map_or_else(|| "—".to_owned(), seconds),
        ));
    }
    out.push_str(&without_need(cost));
    for n in &cost.not_applicable {
        out.push_str(&format!("     —  {}: {}\n", n.estimator, n.reason));
    }
    out
}

/// What unneeded effects cost; empty where there are none.
fn without_need(cost: &SceneCost) -> String {
    let mut out = String::new();
    for (e, need) in with_effects(cost) {
        let times = |ratio: &Interval| format!("{} {}", number(ratio.value), range(ratio, number));
        out.push_str(&format!(
            "  {}: {} × the time{}, {} compiling against {}; {}\n",
            e.name,
            times(&need.time_ratio),
            if need.is_tie() { ", a tie" } else { "" },
            seconds(e.compile_seconds),
            seconds(cost.estimators[need.against].compile_seconds),
            agreement(&need.agreement),
        ));
    }
    out
}
