//! Arguments that several commands share: the scene, and which estimator is run on it.

use super::plan::Plan;
use direkt::error::Error;
use direkt::low_level::console::say;
use direkt::low_level::gpu::Context;
use direkt::low_level::render::memory;
use direkt::scene::load::{LoadOptions, load_with_files};
use direkt::scene::{Aov, EstimatorFlags, FilmSize, Scene, validate};
use std::path::PathBuf;

/// Where the files that scenes name are looked up.
#[derive(Debug, clap::Args)]
pub struct AssetArguments {
    /// Further folder in which files that a scene names are looked up; may be repeated
    #[arg(long, value_name = "DIR")]
    assets: Vec<PathBuf>,
}

impl AssetArguments {
    /// How scenes are read.
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            assets: self.assets.clone(),
            capacity: memory::capacity(),
        }
    }

    /// Reads the scene of `path`, of at most as many triangles as `device` takes, where it is open.
    /// Files that `plan` is going to write are refused where it reads them.
    pub fn load(
        &self,
        path: &PathBuf,
        plan: &mut Plan,
        device: Option<&Context>,
    ) -> Result<Scene, Error> {
        plan.spare([path], "the scene itself")?;
        let mut options = self.options();
        let capacities = options
            .capacity
            .into_iter()
            .chain(device.map(Context::capacity));
        options.capacity = capacities.min_by_key(|c| c.triangles);
        let (scene, files) = load_with_files(path, &options);
        let scene = scene?;
        plan.spare(&files, "a file that the scene reads")?;
        Ok(scene)
    }
}

/// Says on stderr what `scene` asks for and direkt does not do.
pub fn warn(scene: &Scene) {
    for warning in &scene.warnings {
        let source = scene.source.display();
        say(format_args!("direkt: warning: {source}: {warning}"));
    }
}

/// The scene file.
#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// The scene: .toml, .gltf or .glb
    pub scene: PathBuf,
    #[command(flatten)]
    assets: AssetArguments,
}

impl SceneArguments {
    /// Reads the scene; see [`AssetArguments::load`].
    pub fn load(&self, plan: &mut Plan, device: Option<&Context>) -> Result<Scene, Error> {
        self.assets.load(&self.scene, plan, device)
    }
}

/// Scene files.
#[derive(Debug, clap::Args)]
pub struct SceneListArguments {
    /// The scenes: .toml, .gltf or .glb
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    #[command(flatten)]
    assets: AssetArguments,
}

impl SceneListArguments {
    /// Reads the scenes, and says on stderr what they ask for and direkt does not do. Files that
    /// `plan` is going to write are refused where they read them.
    pub fn load(&self, plan: &mut Plan, device: Option<&Context>) -> Result<Vec<Scene>, Error> {
        let load = |path: &PathBuf| {
            let scene = self.assets.load(path, plan, device)?;
            warn(&scene);
            Ok(scene)
        };
        self.scenes.iter().map(load).collect()
    }
}

/// Flags that override the scene's seed and size.
#[derive(Debug, clap::Args)]
pub struct ImageArguments {
    /// Seed of the random numbers
    #[arg(long)]
    seed: Option<u32>,
    /// Size of the image
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<FilmSize>,
}

impl ImageArguments {
    /// Changes `scene` and validates it.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        scene.render.seed = self.seed.unwrap_or(scene.render.seed);
        if let Some(size) = self.size.filter(|&size| size != scene.film) {
            scene.film = size;
            // What it says holds for the film of the file.
            scene.expect = None;
        }
        validate::validate(scene)
    }
}

/// Flags that override the scene's estimator, seed and size.
#[derive(Debug, clap::Args)]
pub struct EstimatorArguments {
    /// Seed and size.
    #[command(flatten)]
    pub image: ImageArguments,
    #[command(flatten)]
    estimator: EstimatorFlags,
}

impl EstimatorArguments {
    /// Changes `scene` and validates it.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        self.estimator.apply(&mut scene.render.estimator);
        self.image.apply(scene)
    }
}

/// Which images are made beside radiance.
#[derive(Debug, clap::Args)]
pub struct AovArguments {
    /// Images beside radiance, as further channels of the EXR, separated by commas: see docs/aov.md
    #[arg(long = "aov", value_name = "LIST", value_enum, value_delimiter = ',')]
    pub aovs: Vec<Aov>,
}

impl AovArguments {
    /// Changes `scene`: what is named here is made instead of what it names.
    pub fn apply(&self, scene: &mut Scene) {
        if !self.aovs.is_empty() {
            scene.render.aovs = self.aovs.iter().copied().collect();
        }
    }
}

/// `WIDTHxHEIGHT`.
pub fn parse_size(text: &str) -> Result<FilmSize, String> {
    let wrong = || {
        format!(
            "expected WIDTHxHEIGHT such as 640x480, each from 1 to {}",
            FilmSize::MAX_SIDE
        )
    };
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let side = |s: &str| {
        let side = s
            .parse()
            .ok()
            .filter(|n| (1..=FilmSize::MAX_SIDE).contains(n));
        side.ok_or_else(wrong)
    };
    Ok(FilmSize {
        width: side(width)?,
        height: side(height)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_parsed_and_checked() {
        assert_eq!(
            parse_size("640x480"),
            Ok(FilmSize {
                width: 640,
                height: 480
            })
        );
        for wrong in ["640", "0x4", "4x", "-1x4", "40000x4", "4x4x4"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
