//! Lights, switched and dimmed in the window.

use crate::scene::{EnvironmentRadiance, Light, Scene};

/// Which light of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Which {
    /// The shape of this index.
    Shape(usize),
    /// The light without a surface of this index.
    Light(usize),
    Environment,
}

/// One light and how it is switched.
#[derive(Debug, Clone, PartialEq)]
pub struct Switch {
    which: Which,
    /// Its name.
    pub name: String,
    /// Whether it is off.
    pub muted: bool,
    /// Whether it and others like it are the only ones that are on.
    pub solo: bool,
    /// Factor on what it emits.
    pub scale: f64,
}

impl Switch {
    fn new(which: Which, name: String) -> Self {
        Self {
            which,
            name,
            muted: false,
            solo: false,
            scale: 1.0,
        }
    }
}

/// The lights of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lights(pub Vec<Switch>);

impl Lights {
    /// Those of `scene`, all on.
    pub fn of(scene: &Scene) -> Self {
        let shapes = scene.shapes.iter().enumerate();
        let emitting = shapes.filter(|(_, s)| s.emission.is_some());
        let mut all: Vec<_> = emitting
            .map(|(i, shape)| Switch::new(Which::Shape(i), shape.name.clone()))
            .collect();
        all.extend(scene.lights.iter().enumerate().map(|(i, light)| {
            let kind = match light {
                Light::Point { .. } => "point",
                Light::Spot { .. } => "spot",
                Light::Directional { .. } => "directional",
                Light::Sun { .. } => "sun",
            };
            Switch::new(Which::Light(i), format!("lights[{i}]: {kind}"))
        }));
        let environment = scene.environment.as_ref().map(|e| match &e.radiance {
            EnvironmentRadiance::Constant(_) => "environment".to_owned(),
            EnvironmentRadiance::Map(map) => format!("environment: {}", map.source),
        });
        all.extend(environment.map(|name| Switch::new(Which::Environment, name)));
        Self(all)
    }

    /// Whether every light is as the file has it.
    pub fn are_as_in_file(&self) -> bool {
        (0..self.0.len()).all(|i| (self.factor(i) - 1.0).abs() <= 0.0)
    }

    /// Factor on light `index`.
    fn factor(&self, index: usize) -> f64 {
        let light = &self.0[index];
        let silenced = light.muted || (!light.solo && self.0.iter().any(|l| l.solo));
        if silenced { 0.0 } else { light.scale }
    }

    /// Switches and dims the lights of `scene`, which they were made of.
    pub fn apply(&self, scene: &mut Scene) {
        for (index, light) in self.0.iter().enumerate() {
            let factor = self.factor(index);
            match light.which {
                Which::Shape(i) => {
                    if let Some(emission) = &mut scene.shapes[i].emission {
                        emission.radiance *= factor;
                    }
                }
                Which::Light(i) => *scene.lights[i].strength_mut() *= factor,
                Which::Environment => {
                    if let Some(environment) = &mut scene.environment {
                        environment.scale *= factor;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::{LoadOptions, load};

    fn scene() -> Scene {
        let options = LoadOptions::default();
        load("scenes/spot_and_sun.toml".as_ref(), &options).expect("the scene")
    }

    #[test]
    fn a_solo_light_shines_alone() {
        let mut scene = scene();
        let mut lights = Lights::of(&scene);
        assert!(lights.are_as_in_file() && lights.0.len() > 1);
        let before = scene.clone();
        lights.apply(&mut scene);
        assert_eq!(scene, before);
        let last = lights.0.len() - 1;
        lights.0[last].solo = true;
        lights.0[last].scale = 2.0;
        lights.apply(&mut scene);
        let factors: Vec<_> = (0..=last).map(|i| lights.factor(i)).collect();
        assert!(factors[..last].iter().all(|&f| f <= 0.0), "{factors:?}");
        assert!((factors[last] - 2.0).abs() < 1e-15);
        assert!(!lights.are_as_in_file());
        lights.0[last].muted = true;
        assert!(lights.factor(last) <= 0.0);
    }
}
