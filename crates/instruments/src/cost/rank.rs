//! From measurements to what is told.

use super::budget::{Measured, Work};
use super::effects::WithoutNeed;
use super::estimator::names;
use super::interval::{Interval, NORMAL_95};
use super::measures::{Lines, Point, Rank, Reached, ranks, time_ratio};
use super::reference::{Reference, Source};
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
        let ranks = self.ranks(&measured);
        let without_need = self.without_need(&measured);
        let compared: Vec<_> = self.runners.iter().map(|r| r.estimator).collect();
        let runners = self.runners.iter().zip(names(&compared));
        let measures = curves.iter().zip(ranks).zip(measured.equal_time);
        let all = runners.zip(measures).zip(without_need);
        let estimators = all.map(
            |(((runner, name), ((points, rank), equal_time)), without_need)| {
                let last = points.last().expect("three counts");
                let per = 1.0 / (last.samples as f64 * self.scene.film.pixels() as f64);
                let lines = Lines::new(points);
                let target = self.settings.target;
                // Where an error ends in a bias, a line says nothing beyond what was measured.
                let known = |r: &Reached| runner.biased.is_none() || !r.extrapolated;
                let reach =
                    |factor: f64| lines.and_then(|l| l.reach(factor * target)).filter(known);
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
                    without_need,
                }
            },
        );
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

    /// Of every estimator the family, by the index of its first.
    fn family_of(&self) -> Vec<usize> {
        let families = self.families();
        let first_of = |family: Vec<usize>| family.iter().map(|_| family[0]).collect::<Vec<_>>();
        families.into_iter().flat_map(first_of).collect()
    }

    /// The places: in a family, whose errors are the same, by times in pairs.
    fn ranks(&self, measured: &Measured) -> Vec<Rank> {
        let last = |points: &Vec<Point>| points.last().expect("three counts").efficiency;
        let efficiencies: Vec<_> = measured.curves.iter().map(last).collect();
        let family = self.family_of();
        let exact = |i: usize| self.runners[i].agreement.is_exact();
        ranks(&efficiencies, |i, j| {
            let in_pairs = family[i] == family[j] && exact(i) && exact(j);
            in_pairs.then(|| time_ratio(&measured.times[j], &measured.times[i]))
        })
    }

    /// What unneeded effects cost every estimator; none where there are
    /// none.
    fn without_need(&self, measured: &Measured) -> Vec<Option<WithoutNeed>> {
        let of = |(i, against): (usize, usize)| {
            let runner = &self.runners[i];
            let time = |i: usize| &measured.times[i];
            let agreement = runner.agreement;
            (i != against).then(|| WithoutNeed {
                against,
                effects: runner.without_need.iter().map(|e| e.name()).collect(),
                agreement,
                time_ratio: time_ratio(time(i), time(against)),
                efficiency_ratio: agreement
                    .is_exact()
                    .then(|| time_ratio(time(against), time(i))),
                compile_ratio: runner.compile_seconds / self.runners[against].compile_seconds,
            })
        };
        self.family_of().into_iter().enumerate().map(of).collect()
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
