//! What unneeded effects cost.

use super::figures::{self, with_effects};
use super::format::{agreement, escape, grouped, number, seconds};
use super::tables::{row, table, with_interval};
use crate::cost::effects::Agreement;
use crate::cost::{EstimatorCost, Interval, SceneCost};

/// Figure and table; empty where every estimator is as the scene calls for it.
pub fn section(cost: &SceneCost) -> String {
    let Some(figure) = figures::effects(cost) else {
        return String::new();
    };
    format!(
        "<h3>Effects that the scene does not call for</h3>\n<p>What is compiled in without need makes no difference to the image, \
         so that at equal samples the error is equal. What it costs is time.</p>\n\
         <figure class=\"wide\">{}</figure>\n{}<p class=\"faint\">= marks ties: the interval of the ratio contains 1. Times were \
         measured in pairs, one image with and one without, at the largest number of samples; each kernel was compiled once, \
         nothing kept from before, and its time has no interval here: <code>direkt explain --measure</code> tells one.</p>\n{}",
        figure.svg.inline(),
        comparison(cost),
        what_differs(cost),
    )
}

/// What else makes ties; nothing where every estimator is as the scene calls for it.
pub fn ties(cost: &SceneCost) -> &'static str {
    if with_effects(cost).next().is_none() {
        return "";
    }
    ", or, where only effects differ, whose ratio of times in pairs has an interval with 1 in it"
}

/// Every estimator and below it the same with further effects.
fn comparison(cost: &SceneCost) -> String {
    let head = [
        "estimator",
        "time per<br>sample",
        "ratio of<br>times",
        "efficiency<br><small>1/(relMSE · s)</small>",
        "ratio of<br>efficiencies",
        "compile",
        "ratio of<br>compile times",
        "pixels that differ<br><small>of those compared</small>",
    ]
    .map(str::to_owned);
    let body: String = cost.estimators.iter().map(|e| row(&cells(e), "")).collect();
    table(" class=\"named\"", &head, &body)
}

fn cells(e: &EstimatorCost) -> [String; 8] {
    let none = || "—".to_owned();
    let need = e.without_need.as_ref();
    let tied = |ratio: &Interval| {
        let mark = if need.is_some_and(|n| n.is_tie()) {
            "= "
        } else {
            ""
        };
        format!("{mark}{}", with_interval(ratio, number))
    };
    let efficiency_ratio = need.and_then(|n| n.efficiency_ratio.as_ref());
    [
        escape(&e.name),
        with_interval(&e.seconds_per_sample, seconds),
        need.map_or_else(none, |n| tied(&n.time_ratio)),
        with_interval(&e.efficiency, number),
        efficiency_ratio.map_or_else(none, tied),
        seconds(e.compile_seconds),
        need.map_or_else(none, |n| number(n.compile_ratio)),
        need.map_or_else(none, |n| {
            let Agreement {
                pixels,
                pixels_differ,
                ..
            } = n.agreement;
            format!(
                "{}<small>of {}</small>",
                grouped(pixels_differ as f64),
                grouped(pixels as f64)
            )
        }),
    ]
}

/// Whether images are the same, in a sentence for all or for each that is not.
fn what_differs(cost: &SceneCost) -> String {
    let mut differ = with_effects(cost)
        .filter(|(_, need)| !need.agreement.is_exact())
        .map(|(e, need)| format!("{}: {}", escape(&e.name), agreement(&need.agreement)))
        .peekable();
    if differ.peek().is_none() {
        return "<p class=\"faint\">All images were the same bit for bit.</p>\n".to_owned();
    }
    let differ: Vec<_> = differ.collect();
    format!(
        "<p><b>Images differ</b>, so that their errors need not be equal. {}.</p>\n",
        differ.join("; ")
    )
}
