//! Which estimators are compared on a scene.

use crate::emitters::{Emitter, Emitters};
use crate::scene::{LightSelection, Sampler, Strategy};
use serde::Serialize;

/// One way to estimate direct lighting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Estimator {
    /// How directions are chosen.
    pub strategy: Strategy,
    /// How one of several lights is chosen.
    pub light_selection: LightSelection,
    /// How random numbers are made.
    pub sampler: Sampler,
}

impl Estimator {
    /// A name among estimators of which several choose lights in different ways, or all in the same.
    pub fn name(&self, with_selection: bool) -> String {
        if with_selection {
            return self.to_string();
        }
        format!("{} · {}", self.strategy, self.sampler)
    }
}

impl std::fmt::Display for Estimator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            strategy,
            light_selection,
            sampler,
        } = self;
        write!(f, "{strategy} · {sampler} · {light_selection}")
    }
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

/// All combinations.
pub fn combinations(
    strategies: &[Strategy],
    selections: &[LightSelection],
    samplers: &[Sampler],
) -> Vec<Estimator> {
    let mut all = Vec::new();
    for &strategy in strategies {
        for &light_selection in selections {
            for &sampler in samplers {
                all.push(Estimator {
                    strategy,
                    light_selection,
                    sampler,
                });
            }
        }
    }
    all
}

/// Why `strategy` is of no use under `emitters`; `None` where it is.
///
/// What a strategy does with lights without a surface is told from its name, so that strategies to come need no entry
/// here: `light-…` and `mis-…` choose points on lights, all others directions, which never meet such a light.
pub fn why_not(strategy: Strategy, emitters: &Emitters) -> Option<String> {
    let lights = &emitters.lights;
    let name = strategy.to_string();
    let samples_lights = name.starts_with("light-") || name.starts_with("mis-");
    let delta = |light: &Emitter| matches!(light, Emitter::Delta(_));
    if lights.is_empty() {
        return Some("the scene has no light: every estimator gives black".to_owned());
    }
    if !samples_lights && lights.iter().all(delta) {
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
    use crate::scene::Light;
    use glam::DVec3;

    fn emitters(lights: Vec<Emitter>) -> Emitters {
        Emitters {
            lights,
            ..Emitters::default()
        }
    }

    #[test]
    fn directions_do_not_meet_points() {
        let point = Emitter::Delta(Light::Point {
            position: DVec3::ZERO,
            intensity: DVec3::ONE,
        });
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
    fn all_combinations_are_there() {
        let all = combinations(
            &[Strategy::Bsdf, Strategy::MisPower],
            &[LightSelection::Power],
            &[Sampler::Independent, Sampler::Sobol],
        );
        let names: Vec<_> = all.iter().map(|e| e.name(false)).collect();
        let expected = [
            "bsdf · independent",
            "bsdf · sobol",
            "mis-power · independent",
            "mis-power · sobol",
        ];
        assert_eq!(names, expected);
    }
}
