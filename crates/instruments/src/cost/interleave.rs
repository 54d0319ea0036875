//! The estimators in turns.
//!
//! Estimators that differ in nothing but their effects are a *family*: they give the same image, so
//! that they get the same random numbers, one after another, and their images are compared. Their
//! errors are the same, and of their times the ratios are told in pairs.

use super::budget::Work;
use super::error::Errors;
use super::estimator::Estimator;
use super::interrupted::Interrupted;
use super::reference::Reference;
use super::runner::{Replicates, Runner};

/// Indices of the estimators of each family, the one as the scene calls for it first.
fn families(estimators: impl Iterator<Item = Estimator>) -> Vec<Vec<usize>> {
    let mut families: Vec<(Estimator, Vec<usize>)> = Vec::new();
    for (i, estimator) in estimators.enumerate() {
        let called_for = estimator.as_called_for();
        match families
            .last_mut()
            .filter(|(first, _)| *first == called_for)
        {
            Some((_, members)) => members.push(i),
            None => families.push((called_for, vec![i])),
        }
    }
    families.into_iter().map(|(_, members)| members).collect()
}

impl Work<'_, '_> {
    /// Indices of the estimators of each family, the one as the scene calls for it first.
    pub(super) fn families(&self) -> Vec<Vec<usize>> {
        families(self.runners.iter().map(|r| r.estimator))
    }

    /// No images yet of any estimator.
    pub(super) fn empty(&self, samples: u64) -> Vec<Replicates> {
        let of = |runner: &Runner<'_>| Replicates {
            samples,
            seconds: Vec::new(),
            errors: Errors::new(self.scene.film, runner.estimator.settings.sampler),
        };
        self.runners.iter().map(of).collect()
    }

    /// One image by every estimator; each turn begins with another family, and in it with another
    /// member.
    pub(super) fn turn(
        &mut self,
        current: &mut [Replicates],
        reference: &Reference,
        turns: &mut usize,
    ) -> Result<(), Interrupted> {
        let mut families = self.families();
        let count = families.len();
        families.rotate_left(*turns % count);
        for family in &families {
            self.family_turn(family, current, reference, *turns)?;
        }
        *turns += 1;
        Ok(())
    }

    /// One image by every member, of the same random numbers: all or none, so that their times are
    /// in pairs.
    fn family_turn(
        &mut self,
        family: &[usize],
        current: &mut [Replicates],
        reference: &Reference,
        turns: usize,
    ) -> Result<(), Interrupted> {
        let seed = self.seeds.draw();
        let mut runs = Vec::new();
        for k in 0..family.len() {
            let i = family[(k + turns) % family.len()];
            let run = self.runners[i].run(seed, current[i].samples, self.stop)?;
            self.spent += run.seconds;
            runs.push((i, run));
        }
        runs.sort_by_key(|(i, _)| *i);
        for (i, run) in &runs {
            current[*i].seconds.push(run.seconds);
            current[*i].errors.add(&run.film, reference);
            if *i != family[0] {
                let agreement = &mut self.runners[*i].agreement;
                agreement.add(&runs[0].1.film, &run.film);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::effects::Compiled;
    use crate::cost::estimator::{Choices, combinations};
    use direkt::low_level::effects::Effect;
    use direkt::scene::{RenderSettings, Sampler};

    #[test]
    fn families_differ_in_effects_alone() {
        let mut choices = Choices {
            samplers: vec![Sampler::Independent, Sampler::Sobol],
            ..Choices::of(&RenderSettings::default())
        };
        let of = |choices: &Choices| families(combinations(choices).into_iter());
        assert_eq!(of(&choices), [[0], [1]]);
        choices
            .effects
            .extend([Compiled::With(Effect::Disks), Compiled::WithEverything]);
        assert_eq!(of(&choices), [[0, 1, 2], [3, 4, 5]]);
    }
}
