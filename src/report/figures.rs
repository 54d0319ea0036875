//! The plots of a scene.

use super::chart::{self, Curve};
use super::format::short;
use crate::cost::{EstimatorCost, Point, SceneCost};
use crate::drawing::bars::{self, Bar};
use crate::drawing::svg::{SERIES, Svg};
use crate::scene::{Sampler, Strategy};
use clap::ValueEnum;

/// A plot.
#[derive(Debug)]
pub struct Figure {
    /// What its files are called.
    pub name: &'static str,
    /// The drawing.
    pub svg: Svg,
}

/// Number of a strategy's colour: the same on every page.
pub fn series(strategy: Strategy) -> usize {
    let all = Strategy::value_variants();
    all.iter().position(|s| *s == strategy).unwrap_or(0) % SERIES
}

/// Number of a sampler's dashes.
fn dash(sampler: Sampler) -> usize {
    let all = Sampler::value_variants();
    all.iter().position(|s| *s == sampler).unwrap_or(0)
}

/// The estimators, best first.
pub fn ranked(cost: &SceneCost) -> Vec<&EstimatorCost> {
    let mut ranked: Vec<_> = cost.estimators.iter().collect();
    ranked.sort_by(|a, b| {
        let efficiency = b.efficiency.value.total_cmp(&a.efficiency.value);
        a.rank.rank.cmp(&b.rank.rank).then(efficiency)
    });
    ranked
}

/// Error against time, error against samples, efficiency.
pub fn of(cost: &SceneCost) -> [Figure; 3] {
    let guide = format!("relMSE {}", short(cost.target));
    let curves = |x: &dyn Fn(&Point) -> f64| -> Vec<Curve> {
        let curve = |e: &EstimatorCost| Curve {
            name: e.name.clone(),
            series: series(e.estimator.strategy),
            dash: dash(e.estimator.sampler),
            points: e.points.iter().map(|p| (x(p), p.rel_mse)).collect(),
        };
        cost.estimators.iter().map(curve).collect()
    };
    let error = "relative mean squared error";
    let bar = |e: &&EstimatorCost| Bar {
        name: e.name.clone(),
        series: series(e.estimator.strategy),
        value: e.efficiency,
    };
    let bars: Vec<_> = ranked(cost).iter().map(bar).collect();
    let guide = Some((cost.target, guide.as_str()));
    let time = chart::draw(
        "Error against time",
        ["seconds of rendering", error],
        &curves(&|p| p.seconds.value),
        guide,
    );
    let samples = chart::draw(
        "Error against samples",
        ["samples per pixel", error],
        &curves(&|p| p.samples as f64),
        guide,
    );
    let axis = "efficiency 1/(relMSE · seconds), per second";
    let efficiency = bars::draw("Efficiency", axis, &bars);
    [
        ("error-time", time),
        ("error-samples", samples),
        ("efficiency", efficiency),
    ]
    .map(|(name, svg)| Figure { name, svg })
}
