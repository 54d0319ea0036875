//! Which estimators are compared on a scene.

use super::effects::Compiled;
use direkt::low_level::effects::Effect;
use direkt::low_level::emitters::{Emitter, Emitters};
use direkt::low_level::prepare::Prepared;
use direkt::scene::{
    EstimatorSettings, LightSampling, LightSelection, RenderSettings, Sampler, ShadowPattern,
    ShadowRays, Strategy,
};
use serde::Serialize;

/// One way to estimate direct lighting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Estimator {
    /// Its settings.
    #[serde(flatten)]
    pub settings: EstimatorSettings,
    /// The effects that it is compiled with.
    pub effects: Compiled,
}

impl Estimator {
    /// The one of `settings`.
    pub fn of(settings: &RenderSettings) -> Self {
        Self {
            settings: settings.estimator,
            effects: Compiled::CalledFor,
        }
    }

    /// The same with the effects that the scene calls for: both give the same image, bit for bit.
    pub fn as_called_for(self) -> Self {
        Self {
            effects: Compiled::CalledFor,
            ..self
        }
    }

    /// The estimator that `prepared`, made ready for this one, comes to: what makes no difference
    /// there is set to its default.
    pub fn effective(self, prepared: &Prepared) -> Self {
        let calls_for = |effect| prepared.effects.contains(effect);
        let mut settings = self.settings;
        settings.light_selection = if calls_for(Effect::AllLights) {
            LightSelection::All
        } else if calls_for(Effect::LightTree) {
            LightSelection::Tree
        } else if calls_for(Effect::LightChoice) {
            match settings.light_selection {
                LightSelection::Power => LightSelection::Power,
                _ => LightSelection::Uniform,
            }
        } else {
            LightSelection::default()
        };
        if !settings.strategy.is_mis() {
            settings.light_sampling = LightSampling::default();
        }
        if !calls_for(Effect::ShadowRays) {
            settings.shadow_rays = ShadowRays::default();
        }
        settings.shadow_pattern = prepared.shadow_pattern();
        Self { settings, ..self }
    }

    /// Its name with light selection, shadow rays and their pattern, and effects, each where
    /// `told`.
    fn name(&self, told: LabelParts) -> String {
        let mut name = format!("{} · {}", self.settings.strategy, self.settings.sampler);
        let mut tell = |told: bool, what: String| {
            if told {
                name.push_str(" · ");
                name.push_str(&what);
            }
        };
        tell(
            told.sampling && self.settings.strategy.is_mis(),
            self.settings.light_sampling.to_string(),
        );
        tell(told.selection, self.settings.light_selection.to_string());
        let plural = if self.settings.shadow_rays == ShadowRays::Number(1) {
            ""
        } else {
            "s"
        };
        tell(
            told.rays,
            format!("{} ray{plural}", self.settings.shadow_rays),
        );
        tell(told.pattern, self.settings.shadow_pattern.to_string());
        tell(
            told.adaptive && self.settings.adaptive,
            "adaptive".to_owned(),
        );
        tell(told.effects, self.effects.to_string());
        name
    }
}

/// The whole name, without the shadow rays and effects where there is nothing to say of them.
impl std::fmt::Display for Estimator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let told = LabelParts {
            sampling: self.settings.light_sampling != LightSampling::default(),
            selection: true,
            rays: self.settings.shadow_rays != ShadowRays::default(),
            pattern: self.settings.shadow_pattern != ShadowPattern::Random,
            adaptive: true,
            effects: self.effects != Compiled::CalledFor,
        };
        f.write_str(&self.name(told))
    }
}

/// What a name tells besides strategy and sampler.
#[derive(Debug, Clone, Copy, Default)]
struct LabelParts {
    sampling: bool,
    selection: bool,
    rays: bool,
    pattern: bool,
    adaptive: bool,
    effects: bool,
}

/// Names of `estimators`, which tell what differs among them.
pub fn names(estimators: &[Estimator]) -> Vec<String> {
    let told = LabelParts {
        sampling: differ(estimators, |e| e.settings.light_sampling),
        selection: differ(estimators, |e| e.settings.light_selection),
        rays: differ(estimators, |e| e.settings.shadow_rays),
        pattern: differ(estimators, |e| e.settings.shadow_pattern),
        adaptive: differ(estimators, |e| e.settings.adaptive),
        effects: estimators.iter().any(|e| e.effects != Compiled::CalledFor),
    };
    estimators.iter().map(|e| e.name(told)).collect()
}

fn differ<T: PartialEq>(estimators: &[Estimator], key: impl Fn(&Estimator) -> T) -> bool {
    let pairs = estimators.windows(2);
    pairs.into_iter().any(|pair| key(&pair[0]) != key(&pair[1]))
}

/// An estimator that a scene cannot use.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotApplicable {
    /// The estimator.
    #[serde(flatten)]
    pub estimator: Estimator,
    /// Why not.
    pub reason: String,
}

/// What to combine into estimators.
#[derive(Debug, Clone, PartialEq)]
pub struct Choices {
    /// All that is not varied.
    pub base: EstimatorSettings,
    /// How directions are chosen.
    pub strategies: Vec<Strategy>,
    /// How a point of a chosen light is chosen, for strategies that do not say.
    pub light_samplings: Vec<LightSampling>,
    /// How one of several lights is chosen.
    pub light_selections: Vec<LightSelection>,
    /// Shadow rays per camera ray.
    pub shadow_rays: Vec<ShadowRays>,
    /// Where on the lights their points lie.
    pub shadow_patterns: Vec<ShadowPattern>,
    /// How random numbers are made.
    pub samplers: Vec<Sampler>,
    /// Whether sampling is adaptive.
    pub adaptive: Vec<bool>,
    /// The effects that they are compiled with.
    pub effects: Vec<Compiled>,
}

impl Choices {
    /// What `settings` say, nothing else.
    pub fn of(settings: &RenderSettings) -> Self {
        Self {
            base: settings.estimator,
            strategies: vec![settings.estimator.strategy],
            light_samplings: vec![settings.estimator.light_sampling],
            light_selections: vec![settings.estimator.light_selection],
            shadow_rays: vec![settings.estimator.shadow_rays],
            shadow_patterns: vec![settings.estimator.shadow_pattern],
            samplers: vec![settings.estimator.sampler],
            adaptive: vec![settings.estimator.adaptive],
            effects: vec![Compiled::CalledFor],
        }
    }
}

/// All combinations, each once. Strategies that say themselves how a point of a light is chosen are
/// combined with the default alone. Those that differ in their effects alone follow one another.
pub fn combinations(choices: &Choices) -> Vec<Estimator> {
    let mut all = vec![Estimator {
        settings: EstimatorSettings {
            light_sampling: LightSampling::default(),
            ..choices.base
        },
        effects: Compiled::CalledFor,
    }];
    vary(&mut all, &choices.strategies, |e, v| {
        e.settings.strategy = v
    });
    vary(&mut all, &choices.light_samplings, |e, v| {
        if e.settings.strategy.is_mis() {
            e.settings.light_sampling = v;
        }
    });
    vary(&mut all, &choices.light_selections, |e, v| {
        e.settings.light_selection = v;
    });
    vary(&mut all, &choices.shadow_rays, |e, v| {
        e.settings.shadow_rays = v
    });
    vary(&mut all, &choices.shadow_patterns, |e, v| {
        e.settings.shadow_pattern = v;
    });
    vary(&mut all, &choices.samplers, |e, v| e.settings.sampler = v);
    vary(&mut all, &choices.adaptive, |e, v| e.settings.adaptive = v);
    vary(&mut all, &choices.effects, |e, v| e.effects = v);
    let mut seen = Vec::new();
    all.retain(|e| {
        let new = !seen.contains(e);
        seen.push(*e);
        new
    });
    all
}

/// Every one of `all` with every one of `values`.
fn vary<T: Copy>(all: &mut Vec<Estimator>, values: &[T], set: impl Fn(&mut Estimator, T)) {
    let with = |estimator: &Estimator, value: T| {
        let mut estimator = *estimator;
        set(&mut estimator, value);
        estimator
    };
    *all = all
        .iter()
        .flat_map(|e| values.iter().map(move |&v| (e, v)))
        .map(|(e, v)| with(e, v))
        .collect();
}

/// Why `strategy` is of no use under `emitters`; `None` where it is.
pub fn why_not(strategy: Strategy, emitters: &Emitters) -> Option<String> {
    let lights = &emitters.lights;
    let delta = |light: &Emitter| matches!(light, Emitter::Delta(_));
    if lights.is_empty() {
        return Some("the scene has no light: every estimator gives black".to_owned());
    }
    if !strategy.samples_lights() && lights.iter().all(delta) {
        return Some(format!(
            "all {} lights are points or directions, which no sampled direction meets",
            lights.len()
        ));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use direkt::scene::{Light, PointLight};
    use glam::DVec3;

    fn emitters(lights: Vec<Emitter>) -> Emitters {
        Emitters {
            lights,
            ..Emitters::default()
        }
    }

    #[test]
    fn directions_do_not_meet_points() {
        let point = Emitter::Delta(Light::Point(PointLight {
            position: DVec3::ZERO,
            intensity: DVec3::ONE,
        }));
        let points = emitters(vec![point, point]);
        let reason = why_not(Strategy::Bsdf, &points).expect("it is of no use");
        assert!(reason.starts_with("all 2 lights"), "{reason}");
        assert!(why_not(Strategy::LightArea, &points).is_none());
        assert!(why_not(Strategy::MisPower, &points).is_none());
        let mixed = emitters(vec![point, Emitter::Environment]);
        assert!(why_not(Strategy::Bsdf, &mixed).is_none());
    }

    #[test]
    fn darkness_is_for_no_one() {
        assert!(why_not(Strategy::MisPower, &emitters(Vec::new())).is_some());
    }

    #[test]
    fn all_combinations_are_there_once_and_are_named_by_what_differs() {
        let mut choices = Choices {
            strategies: vec![Strategy::Bsdf, Strategy::MisPower],
            samplers: vec![Sampler::Independent, Sampler::Sobol, Sampler::Independent],
            ..Choices::of(&RenderSettings::default())
        };
        let expected = [
            "bsdf · independent",
            "bsdf · sobol",
            "mis-power · independent",
            "mis-power · sobol",
        ];
        assert_eq!(names(&combinations(&choices)), expected);
        choices.samplers.truncate(1);
        choices.light_samplings = vec![LightSampling::Area, LightSampling::SolidAngle];
        let expected = [
            "bsdf · independent",
            "mis-power · independent · area",
            "mis-power · independent · solid-angle",
        ];
        assert_eq!(names(&combinations(&choices)), expected);
        choices.strategies.remove(0);
        choices.light_samplings.truncate(1);
        choices.shadow_rays = [1, 4].map(ShadowRays::Number).to_vec();
        choices.shadow_patterns.push(ShadowPattern::Stratified);
        let expected = [
            "mis-power · independent · 1 ray · random",
            "mis-power · independent · 1 ray · stratified",
            "mis-power · independent · 4 rays · random",
            "mis-power · independent · 4 rays · stratified",
        ];
        assert_eq!(names(&combinations(&choices)), expected);
        choices.shadow_rays.truncate(1);
        choices.shadow_patterns.truncate(1);
        choices.effects = vec![
            Compiled::CalledFor,
            Compiled::With(Effect::DepthOfField),
            Compiled::WithEverything,
        ];
        let expected = [
            "mis-power · independent · called for",
            "mis-power · independent · + depth-of-field",
            "mis-power · independent · + everything",
        ];
        assert_eq!(names(&combinations(&choices)), expected);
    }
}
