//! Which estimators are measured on a scene, compiled.

use super::Progress;
use super::budget::Work;
use super::effects::Compiled;
use super::estimator::{self, Estimator, NotApplicable};
use super::interrupted::Interrupted;
use super::runner::{Runner, prepare};
use direkt::error::Error;
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::{Prepared, SceneData};
use direkt::scene::{EstimatorSettings, Sampler, Scene, Strategy};
use std::sync::Arc;

impl<'a> Work<'a, '_> {
    /// Compiles the estimators that the scene can use, and that of the reference where it is
    /// `own_reference`.
    pub(super) fn compile(
        &mut self,
        context: &'a Context,
        own_reference: bool,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let (scene, settings) = (self.scene, self.settings);
        let mut compiled = Vec::new();
        for &estimator in &settings.estimators {
            if (self.stop)() {
                return Err(Interrupted::Stopped);
            }
            // What the scene cannot use without further effects it cannot use with them.
            let called_for = estimator.as_called_for();
            if self
                .not_applicable
                .iter()
                .any(|n| n.estimator == called_for)
            {
                continue;
            }
            progress(&format!("compiling {estimator}"), 0.0);
            let prepared = match usable((scene, &self.data), estimator, &compiled) {
                Ok(prepared) => prepared,
                Err(reason) => {
                    self.not_applicable
                        .push(NotApplicable { estimator, reason });
                    continue;
                }
            };
            compiled.push((estimator.effective(&prepared), estimator));
            let stamp = Some(self.stamps.draw());
            let runner = Runner::new(context, prepared, scene.film, estimator, stamp)?;
            self.runners.push(runner);
        }
        if self.runners.is_empty() {
            let reasons = self.not_applicable.iter();
            let reasons: Vec<_> = reasons
                .map(|n| format!("{}: {}", n.estimator, n.reason))
                .collect();
            return Err(Error::Usage(format!(
                "{}: no estimator is applicable: {}",
                scene.source.display(),
                reasons.join("; ")
            ))
            .into());
        }
        if own_reference {
            let usual = EstimatorSettings::default();
            let estimator = Estimator {
                settings: EstimatorSettings {
                    strategy: Strategy::MisPower,
                    light_selection: settings.estimators[0].settings.light_selection,
                    light_sampling: usual.light_sampling,
                    shadow_rays: usual.shadow_rays,
                    shadow_pattern: usual.shadow_pattern,
                    sampler: Sampler::Sobol,
                    ..scene.render.estimator
                },
                effects: Compiled::CalledFor,
            };
            progress("compiling the reference", 0.0);
            let prepared = prepare(scene, &self.data, estimator).map_err(Error::from)?;
            let runner = Runner::new(context, prepared, scene.film, estimator, None)?;
            self.own = Some(runner);
        }
        Ok(())
    }
}

/// The scene made ready for `estimator`, or why it is of no use there: `compiled` are those before,
/// each after what it comes to.
fn usable(
    (scene, data): (&Scene, &Arc<SceneData>),
    estimator: Estimator,
    compiled: &[(Estimator, Estimator)],
) -> Result<Prepared, String> {
    let prepared = prepare(scene, data, estimator)
        .map_err(|e| format!("{}: {}; expected {}", e.field, e.problem, e.expected))?;
    if let Some(reason) = estimator::why_not(estimator.settings.strategy, &prepared.emitters) {
        return Err(reason);
    }
    if let Some(reason) = estimator.effects.why_not(&prepared.effects) {
        return Err(reason);
    }
    let effective = estimator.effective(&prepared);
    match compiled.iter().find(|(e, _)| *e == effective) {
        Some((_, first)) => Err(format!("on this scene the same as {first}")),
        None => Ok(prepared),
    }
}
