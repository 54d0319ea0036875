//! Lights, switched and dimmed in the window.

use direkt::scene::{EnvironmentRadiance, Scene};
use std::collections::BTreeMap;
use toml_edit::{DocumentMut, Item, Value};

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
            let kind = light.name();
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
        (0..self.0.len()).all(|i| !is_other(self.factor(i), 1.0))
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

impl Lights {
    /// Switches and dims the lights in the text of a TOML scene, which they were made of.
    ///
    /// # Errors
    /// What is switched is no light of that text alone.
    pub fn write(&self, document: &mut DocumentMut) -> Result<(), String> {
        let elsewhere = |name: &str| format!("{name}: not a light of the scene file itself");
        let mut of_tables = BTreeMap::new();
        for (index, light) in self.0.iter().enumerate() {
            let factor = self.factor(index);
            let written = match (light.which, table_of_shape(&light.name)) {
                (Which::Shape(_), Some(table)) => {
                    // The sides of a box, say, are one table.
                    let of_table = *of_tables.entry(table).or_insert(factor);
                    if is_other(of_table, factor) {
                        return Err(format!("{}: its parts are switched apart", light.name));
                    }
                    true
                }
                _ if !is_other(factor, 1.0) => true,
                (Which::Shape(_), None) => false,
                (Which::Light(i), _) => {
                    strength_of(document, i).is_some_and(|strength| multiply(strength, factor))
                }
                (Which::Environment, _) => scale_environment(document, factor),
            };
            if !written {
                return Err(elsewhere(&light.name));
            }
        }
        for (table, factor) in of_tables {
            if is_other(factor, 1.0)
                && !radiance_of(document, table).is_some_and(|item| multiply(item, factor))
            {
                return Err(elsewhere(&format!("shapes[{table}]")));
            }
        }
        Ok(())
    }
}

fn is_other(a: f64, b: f64) -> bool {
    (a - b).abs() > 0.0
}

fn scale_environment(document: &mut DocumentMut, factor: f64) -> bool {
    let Some(environment) = document.get_mut("environment") else {
        return false;
    };
    let scale = environment.get("scale").and_then(Item::as_value);
    let scale = scale.and_then(number).unwrap_or(1.0);
    environment["scale"] = toml_edit::value(scale * factor);
    true
}

/// Index of the `[[shapes]]` table that a shape called `name` was made of.
fn table_of_shape(name: &str) -> Option<usize> {
    let (index, _) = name.strip_prefix("shapes[")?.split_once(']')?;
    index.parse().ok()
}

fn radiance_of(document: &mut DocumentMut, table: usize) -> Option<&mut Item> {
    let shape = document.get_mut("shapes")?.get_mut(table)?;
    shape.get_mut("emission")?.get_mut("radiance")
}

/// What the `[[lights]]` table of this index says of its strength.
fn strength_of(document: &mut DocumentMut, index: usize) -> Option<&mut Item> {
    let light = document.get_mut("lights")?.get_mut(index)?;
    let mut names = ["intensity", "irradiance"].into_iter();
    let name = names.find(|name| light.get(name).is_some())?;
    light.get_mut(name)
}

fn number(value: &Value) -> Option<f64> {
    let integer = value.as_integer().map(|i| i as f64);
    value.as_float().or(integer)
}

/// Multiplies a number or a list of numbers; whether it is that.
fn multiply(item: &mut Item, factor: f64) -> bool {
    let Some(value) = item.as_value_mut() else {
        return false;
    };
    let values: Vec<&mut Value> = match value {
        Value::Array(array) => array.iter_mut().collect(),
        value => vec![value],
    };
    let mut all = true;
    for value in values {
        match number(value) {
            Some(x) => {
                let decor = value.decor().clone();
                *value = Value::from(x * factor);
                *value.decor_mut() = decor;
            }
            None => all = false,
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use direkt::scene::load::{LoadOptions, load};

    fn scene() -> Scene {
        let options = LoadOptions::default();
        load(&example("spot_and_sun"), &options).expect("the scene")
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

    #[test]
    fn what_is_written_is_read_as_it_was_switched() {
        let source = std::fs::read_to_string(example("spot_and_sun")).expect("the scene");
        let mut switched = scene();
        let mut lights = Lights::of(&switched);
        for (i, light) in lights.0.iter_mut().enumerate() {
            light.scale = 0.3 + 0.2 * i as f64;
        }
        lights.0[0].muted = true;
        lights.apply(&mut switched);
        let mut document: DocumentMut = source.parse().expect("TOML");
        lights.write(&mut document).expect("its own lights");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, document.to_string()).expect("written");
        let read = load(&path, &LoadOptions::default()).expect("a scene");
        assert_eq!(read.lights, switched.lights);
        assert_eq!(read.shapes, switched.shapes);
        assert_eq!(read.environment, switched.environment);
        let mut included: DocumentMut = "[[gltf]]\nfile = \"a.glb\"".parse().expect("TOML");
        let error = lights
            .write(&mut included)
            .expect_err("lights of another file");
        assert!(error.contains("not a light of the scene file"), "{error}");
    }
}
