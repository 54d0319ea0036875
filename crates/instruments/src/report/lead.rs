//! The result of a scene in a few sentences.

use super::figures::{ranked, with_effects};
use super::format::{escape, number, range, seconds, short};
use super::tables::reached;
use crate::cost::{Compiled, EstimatorCost, Interval, SceneCost};

/// The result in a sentence or two.
pub fn lead(cost: &SceneCost) -> String {
    // What unneeded effects cost is told by ratios of times in pairs, not by intervals of
    // efficiency.
    let all: Vec<_> = ranked(cost)
        .into_iter()
        .filter(|e| e.without_need.is_none())
        .collect();
    let Some(best) = all.first() else {
        return String::new();
    };
    let mut text = if all.len() > 1 || with_effects(cost).next().is_none() {
        comparison(cost, &all)
    } else {
        String::new()
    };
    if let Some(reached) = reached(best, cost.target) {
        let name = format!("<b>{}</b>", escape(&best.name));
        let about = if reached.extrapolated {
            "would take about"
        } else {
            "takes"
        };
        text.push_str(&format!(
            " To relMSE {} {} {about} {}.",
            short(cost.target),
            if text.is_empty() { &name } else { "it" },
            seconds(reached.seconds.value)
        ));
    }
    text.push_str(&without_need(cost));
    text
}

/// Who of `all`, best first, is how much better.
fn comparison(cost: &SceneCost, all: &[&EstimatorCost]) -> String {
    let (Some(best), Some(last)) = (all.first(), all.last()) else {
        return String::new();
    };
    let mut text = format!("<b>{}</b> ", escape(&best.name));
    let others = best.rank.ties.iter().map(|&i| &cost.estimators[i]);
    let names: Vec<_> = others
        .filter(|e| e.without_need.is_none())
        .map(|e| format!("<b>{}</b>", escape(&e.name)))
        .collect();
    if names.is_empty() {
        text.push_str("is the most efficient");
    } else {
        text.push_str(&format!("leads in a tie with {}", names.join(", ")));
    }
    if last.rank.rank > best.rank.rank {
        let ratio = ratio(&best.efficiency, &last.efficiency);
        text.push_str(&format!(
            ": {} times {} as efficient as {}",
            number(ratio.value),
            range(&ratio, number),
            escape(&last.name)
        ));
    }
    text.push('.');
    text
}

/// What everything costs where nothing calls for it, in a sentence of its own; empty where that was
/// not measured.
fn without_need(cost: &SceneCost) -> String {
    let everything = |e: &EstimatorCost| e.estimator.effects == Compiled::WithEverything;
    let all: Vec<_> = with_effects(cost).filter(|(e, _)| everything(e)).collect();
    let values = || all.iter().map(|(_, need)| &need.time_ratio);
    let between = match all.as_slice() {
        [] => return String::new(),
        [(_, need)] => {
            let tie = if need.is_tie() { ", a tie" } else { "" };
            let interval = range(&need.time_ratio, number);
            format!(
                "{} times {interval} the time{tie}",
                number(need.time_ratio.value)
            )
        }
        _ => {
            let low = values().map(|r| r.value).fold(f64::INFINITY, f64::min);
            let high = values().map(|r| r.value).fold(0.0, f64::max);
            format!("{} to {} times the time", number(low), number(high))
        }
    };
    let same = if all.iter().all(|(_, need)| need.agreement.is_exact()) {
        "the same image"
    } else {
        "images that differ"
    };
    format!(" Everything compiled in that the scene does not call for: {between} for {same}.")
}

/// a/b of independent positive values, by their logarithms.
fn ratio(a: &Interval, b: &Interval) -> Interval {
    let value = a.value / b.value;
    let down = (a.value / a.low).ln().hypot((b.high / b.value).ln());
    let up = (a.high / a.value).ln().hypot((b.value / b.low).ln());
    Interval {
        value,
        low: value * (-down).exp(),
        high: value * up.exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_take_both_intervals() {
        let a = Interval::around(4.0, 0.0);
        let b = Interval {
            value: 2.0,
            low: 1.0,
            high: 4.0,
        };
        let r = ratio(&a, &b);
        assert!((r.value - 2.0).abs() < 1e-12);
        assert!((r.low - 1.0).abs() < 1e-12 && (r.high - 4.0).abs() < 1e-12);
    }
}
