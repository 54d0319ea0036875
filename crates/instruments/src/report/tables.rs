//! The tables of a page.

use super::figures::ranked;
use super::format::{escape, grouped, number, range, seconds, short, slope};
use crate::cost::{EstimatorCost, Interval, Reached, SceneCost};
use std::fmt::Write;

/// A cell: the value, and below it the interval.
pub fn with_interval(interval: &Interval, show: impl Fn(f64) -> String) -> String {
    format!(
        "{}<small>{}</small>",
        show(interval.value),
        range(interval, &show)
    )
}

pub fn row(cells: &[String], class: &str) -> String {
    let cells: Vec<_> = cells.iter().map(|c| format!("<td>{c}</td>")).collect();
    format!("<tr{class}>{}</tr>\n", cells.join(""))
}

pub fn table(class: &str, head: &[String], body: &str) -> String {
    let head: Vec<_> = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    format!(
        "<div class=\"scroll\"><table{class}><thead><tr>{}</tr></thead><tbody>\n{body}</tbody></table></div>\n",
        head.join("")
    )
}

/// All estimators with all that is told of them, best first.
pub fn ranking(cost: &SceneCost) -> String {
    let target = short(cost.target);
    let samples = largest(cost);
    let head = [
        "rank".to_owned(),
        "estimator".to_owned(),
        "efficiency<br><small>1/(relMSE · s)</small>".to_owned(),
        format!(
            "relMSE<br><small>at {} spp</small>",
            grouped(samples as f64)
        ),
        "time per<br>sample".to_owned(),
        "slope against<br>samples".to_owned(),
        "slope against<br>time".to_owned(),
        format!("time to<br>relMSE {target}"),
        "compile".to_owned(),
    ];
    let mut body = String::new();
    for estimator in ranked(cost) {
        let class = if estimator.rank.rank == 1 {
            " class=\"first\""
        } else {
            ""
        };
        body.push_str(&row(&ranking_row(estimator, cost.target), class));
    }
    table("", &head, &body)
}

fn ranking_row(e: &EstimatorCost, target: f64) -> [String; 9] {
    let last = e
        .points
        .last()
        .map_or("—".to_owned(), |p| with_interval(&p.rel_mse, number));
    let tied = if e.rank.ties.is_empty() { "" } else { " =" };
    [
        format!("{}{tied}", e.rank.rank),
        escape(&e.name),
        with_interval(&e.efficiency, number),
        last,
        format!(
            "{}<small>{} M samples/s</small>",
            with_interval(&e.seconds_per_sample, seconds),
            number(e.samples_per_second / 1e6)
        ),
        slope(e.slope_samples),
        slope(e.slope_time),
        reached(e, target).map_or_else(|| "—".to_owned(), time_cell),
        seconds(e.compile_seconds),
    ]
}

/// The largest number of samples that was measured.
pub fn largest(cost: &SceneCost) -> u64 {
    let points = cost.estimators.iter().flat_map(|e| &e.points);
    points.map(|p| p.samples).max().unwrap_or(0)
}

/// When the estimator reaches `target`.
pub fn reached(estimator: &EstimatorCost, target: f64) -> Option<&Reached> {
    let mut all = estimator.reached.iter();
    all.find(|r| (r.target / target - 1.0).abs() < 1e-9)
}

fn time_cell(reached: &Reached) -> String {
    let mark = if reached.extrapolated { "≈ " } else { "" };
    format!("{mark}{}", with_interval(&reached.seconds, seconds))
}

/// Time and samples to the same error, best first.
pub fn equal_error(cost: &SceneCost) -> String {
    let targets = [10.0, 1.0, 0.1].map(|f| f * cost.target);
    let mut head = vec!["estimator".to_owned()];
    for target in targets {
        head.push(format!("time to<br>relMSE {}", short(target)));
        head.push("samples<br>per pixel".to_owned());
    }
    let mut body = String::new();
    for estimator in ranked(cost) {
        let mut cells = vec![escape(&estimator.name)];
        for target in targets {
            match reached(estimator, target) {
                Some(r) => {
                    cells.push(time_cell(r));
                    cells.push(grouped(r.samples.value.max(1.0).ceil()));
                }
                None => cells.extend(["—".to_owned(), "—".to_owned()]),
            }
        }
        body.push_str(&row(&cells, ""));
    }
    table(" class=\"named\"", &head, &body)
}

/// Estimators whose error is not known well, in a sentence; empty where there are none.
pub fn vague(cost: &SceneCost) -> String {
    let last = |e: &&EstimatorCost| e.points.last().is_some_and(|p| !p.is_known());
    let names: Vec<_> = ranked(cost)
        .into_iter()
        .filter(last)
        .map(|e| escape(&e.name))
        .collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        "<p class=\"faint\">Not known to a factor of two at the largest count, because few pixels carry the error or because \
         it lies below the reference's own: {}. A longer --budget would tell more.</p>\n",
        names.join(", ")
    )
}

/// Estimators that the scene cannot use; empty where there are none.
pub fn not_applicable(cost: &SceneCost) -> String {
    if cost.not_applicable.is_empty() {
        return String::new();
    }
    let mut out = "<h3>Not applicable</h3>\n<dl>".to_owned();
    for n in &cost.not_applicable {
        let (name, reason) = (n.estimator.to_string(), &n.reason);
        // Writing to a string cannot fail.
        let _ = write!(out, "<dt>{}</dt><dd>{}</dd>", escape(&name), escape(reason));
    }
    out.push_str("</dl>\n");
    out
}
