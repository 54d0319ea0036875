//! The plots of a scene.

use super::chart::{self, Curve};
use super::format::short;
use crate::cost::{Compiled, EstimatorCost, Point, SceneCost, WithoutNeed};
use crate::drawing::bars::{self, Bar};
use crate::drawing::svg::{SERIES, Svg};
use direkt::scene::{Sampler, Strategy};
use strum::VariantArray;

/// A plot.
#[derive(Debug)]
pub struct Figure {
    /// What its files are called.
    pub name: &'static str,
    /// The drawing.
    pub svg: Svg,
}

/// What the files of all plots are called.
pub const NAMES: [&str; 4] = ["error-time", "error-samples", "efficiency", EFFECTS];
const EFFECTS: &str = "effects";

/// Number of an estimator's colour: that of its strategy, the same on every page; where there is
/// one strategy alone, further ones for the unneeded effects.
fn series(cost: &SceneCost, estimator: &EstimatorCost) -> usize {
    let all = Strategy::VARIANTS;
    let strategy = estimator.estimator.settings.strategy;
    let of_strategy = all.iter().position(|s| *s == strategy).unwrap_or(0);
    let mut others = cost
        .estimators
        .iter()
        .map(|e| e.estimator.settings.strategy);
    if others.any(|other| other != strategy) {
        return of_strategy % SERIES;
    }
    let mut effects: Vec<Compiled> = vec![Compiled::CalledFor];
    for effect in cost.estimators.iter().map(|e| e.estimator.effects) {
        if !effects.contains(&effect) {
            effects.push(effect);
        }
    }
    let of_effect = effects
        .iter()
        .position(|e| *e == estimator.estimator.effects);
    (of_strategy + of_effect.unwrap_or(0)) % SERIES
}

/// Estimators with unneeded effects, in the order in which they were
/// named, and what these cost.
pub fn with_effects(cost: &SceneCost) -> impl Iterator<Item = (&EstimatorCost, &WithoutNeed)> {
    let all = cost.estimators.iter();
    all.filter_map(|e| Some((e, e.without_need.as_ref()?)))
}

/// Number of a sampler's dashes.
fn dash(sampler: Sampler) -> usize {
    let all = Sampler::VARIANTS;
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
            series: series(cost, e),
            dash: dash(e.estimator.settings.sampler),
            thin: e.without_need.is_some(),
            points: e.points.iter().map(|p| (x(p), p.rel_mse)).collect(),
        };
        cost.estimators.iter().map(curve).collect()
    };
    let error = "relative mean squared error";
    let bar = |e: &&EstimatorCost| Bar {
        name: e.name.clone(),
        series: series(cost, e),
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
        (NAMES[0], time),
        (NAMES[1], samples),
        (NAMES[2], efficiency),
    ]
    .map(|(name, svg)| Figure { name, svg })
}

/// Times of unneeded effects over those of what is called for; none where
/// there are none.
pub fn effects(cost: &SceneCost) -> Option<Figure> {
    let bar = |(e, need): (&EstimatorCost, &WithoutNeed)| Bar {
        name: e.name.clone(),
        series: series(cost, e),
        value: need.time_ratio,
    };
    let bars: Vec<_> = with_effects(cost).map(bar).collect();
    let axis = "time for the same samples, over that of what is called for";
    let svg = || bars::draw("Unneeded effects", axis, &bars);
    (!bars.is_empty()).then(|| Figure {
        name: EFFECTS,
        svg: svg(),
    })
}
