//! `direkt preview`: a window in which one sees accuracy arrive.

use super::AdapterArgument;
use super::settings::{AssetArguments, EstimatorArguments};
use direkt::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `direkt preview`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The scene: .toml, .gltf or .glb
    scene: PathBuf,
    #[command(flatten)]
    assets: AssetArguments,
    #[command(flatten)]
    estimator: EstimatorArguments,
    /// Tell on stderr what happens
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    adapter: AdapterArgument,
}

/// Runs the command.
#[cfg(not(feature = "window"))]
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let scene = arguments.scene.display();
    Err(Error::Usage(format!(
        "preview: this direkt was built without its window; with it: \
         cargo run --release --features window -- preview {scene}"
    )))
}

/// Runs the command.
#[cfg(feature = "window")]
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    use super::settings::warn;
    use direkt::scene::load::load_with_files;
    use direkt_window::Options;

    let (scene, files) = load_with_files(&arguments.scene, &arguments.assets.options());
    let mut scene = scene?;
    arguments.estimator.apply(&mut scene)?;
    warn(&scene);
    let options = Options {
        path: arguments.scene.clone(),
        files,
        load: arguments.assets.options(),
        adapter: arguments.adapter.adapter.clone(),
        size: [scene.film.width, scene.film.height],
        verbose: arguments.verbose,
    };
    direkt_window::run(scene, options)?;
    Ok(ExitCode::SUCCESS)
}
