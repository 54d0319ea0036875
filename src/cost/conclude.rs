//! From measurements to what is told.

use super::estimator::names;
use super::interval::{Interval, NORMAL_95};
use super::measures::{Lines, Point, Reached, ranks};
use super::reference::{Reference, Source};
use super::schedule::{Measured, Work};
use super::{EstimatorCost, ReferenceFacts, SceneCost};

impl Work<'_, '_> {
    /// What the measurements say.
    pub(super) fn finish(
        self,
        reference: Reference,
        source: Source,
        measured: Measured,
    ) -> SceneCost {
        let curves = &measured.curves;
        let last = |points: &Vec<Point>| points.last().expect("three counts").efficiency;
        let ranks = ranks(&curves.iter().map(last).collect::<Vec<_>>());
        let compared: Vec<_> = self.runners.iter().map(|r| r.estimator).collect();
        let runners = self.runners.iter().zip(names(&compared));
        let all = runners.zip(curves).zip(ranks).zip(measured.equal_time);
        let estimators = all.map(|((((runner, name), points), rank), equal_time)| {
            let last = points.last().expect("three counts");
            let per = 1.0 / (last.samples as f64 * self.scene.film.pixels() as f64);
            let lines = Lines::new(points);
            let target = self.settings.target;
            // Where an error ends in a bias, a line says nothing beyond what was measured.
            let known = |r: &Reached| runner.biased.is_none() || !r.extrapolated;
            let reach = |factor: f64| lines.and_then(|l| l.reach(factor * target)).filter(known);
            EstimatorCost {
                name: if runner.biased.is_some() {
                    format!("{name} (biased)")
                } else {
                    name
                },
                estimator: runner.estimator,
                biased: runner.biased.clone(),
                compile_seconds: runner.compile_seconds,
                seconds_per_sample: last.seconds.scaled(per),
                samples_per_second: 1.0 / (last.seconds.value * per),
                points: points.clone(),
                slope_samples: lines.map(|l| l.slope_samples()),
                slope_time: lines.map(|l| l.slope_time()),
                efficiency: last.efficiency,
                rank,
                reached: [10.0, 1.0, 0.1].into_iter().filter_map(reach).collect(),
                dropped: runner.dropped,
                equal_time,
            }
        });
        SceneCost {
            scene: self.scene.source.display().to_string(),
            width: self.scene.film.width,
            height: self.scene.film.height,
            primitives: self.runners[0].primitives,
            budget: self.settings.budget,
            seconds: self.spent,
            interrupted: measured.interrupted,
            seed: self.settings.seed,
            reference: facts(&reference, source),
            estimators: estimators.collect(),
            not_applicable: self.not_applicable.clone(),
            target: self.settings.target,
            equal_seconds: measured.equal_seconds,
            reference_image: reference.mean,
        }
    }
}

fn facts(reference: &Reference, source: Source) -> ReferenceFacts {
    let own = reference.own_error();
    let of = |k: usize| match source {
        Source::File { .. } => None,
        Source::Exact { .. } => Some(Interval::exactly(0.0)),
        Source::OwnRun { .. } => {
            let half = NORMAL_95 * own.standard_error[k];
            Some(Interval::around(own.value[k], half))
        }
    };
    ReferenceFacts {
        mse: of(0),
        rel_mse: of(1),
        source,
    }
}
