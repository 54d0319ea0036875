//! `direkt explain`: which effects a scene calls for, and why.

use super::settings::EstimatorArguments;
use super::{JsonArgument, print};
use crate::effects::Effect;
use crate::error::Error;
use crate::gpu::shader::{self, Config};
use crate::render::Prepared;
use crate::scene::load::{LoadOptions, load, schema};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `direkt explain`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The scene: .toml, .gltf or .glb
    #[arg(required_unless_present = "schema")]
    scene: Option<PathBuf>,
    /// Print the JSON Schema of scene files instead, for editors that complete them
    #[arg(long, conflicts_with_all = ["scene", "wgsl"])]
    schema: bool,
    /// Print the linked WGSL of the scene's kernel instead
    #[arg(long)]
    wgsl: bool,
    /// Further folder in which files that the scene names are looked up; may be repeated
    #[arg(long, value_name = "DIR")]
    assets: Vec<PathBuf>,
    #[command(flatten)]
    estimator: EstimatorArguments,
    #[command(flatten)]
    json: JsonArgument,
}

#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    called_for: Vec<CalledFor>,
    left_out: Vec<&'static str>,
    wgsl_bytes: usize,
    primitives: usize,
    bvh_nodes: usize,
    bvh_depth: usize,
    lights: usize,
    biased: Option<String>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct CalledFor {
    name: &'static str,
    reason: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let Some(path) = arguments.scene.as_deref().filter(|_| !arguments.schema) else {
        print(&schema())?;
        return Ok(ExitCode::SUCCESS);
    };
    let options = LoadOptions {
        assets: arguments.assets.clone(),
    };
    let mut scene = load(path, &options)?;
    arguments.estimator.apply(&mut scene)?;
    let settings = scene.render;
    let prepared = Prepared::new(scene, settings.strategy, settings.light_selection);
    let config = Config {
        stack_depth: prepared.stack_depth(),
    };
    let wgsl = shader::link("kernel::direct", prepared.effects.features(), config)?;
    if arguments.wgsl {
        print(&wgsl)?;
        return Ok(ExitCode::SUCCESS);
    }
    let called_for = prepared.effects.iter().map(|(effect, reason)| CalledFor {
        name: effect.name(),
        reason: reason.to_owned(),
    });
    let left_out = Effect::ALL
        .iter()
        .filter(|e| !prepared.effects.contains(**e));
    let report = Report {
        scene: path.display().to_string(),
        called_for: called_for.collect(),
        left_out: left_out.map(|e| e.name()).collect(),
        wgsl_bytes: wgsl.len(),
        primitives: prepared.primitives.len(),
        bvh_nodes: prepared.bvh.nodes.len(),
        bvh_depth: prepared.bvh.depth,
        lights: prepared.emitters.lights.len(),
        biased: prepared.bias(),
        warnings: prepared.scene.warnings.clone(),
    };
    arguments.json.write(&report)?;
    if !arguments.json.is_stdout() {
        print(&text(&report))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn text(report: &Report) -> String {
    let mut out = format!("{} calls for\n", report.scene);
    for effect in &report.called_for {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "  {:22} {}", effect.name, effect.reason);
    }
    let _ = writeln!(out, "left out: {}", report.left_out.join(", "));
    let _ = writeln!(
        out,
        "{} primitives, {} lights, BVH of {} nodes and depth {}, {} bytes of WGSL",
        report.primitives, report.lights, report.bvh_nodes, report.bvh_depth, report.wgsl_bytes,
    );
    for warning in report.biased.iter().chain(&report.warnings) {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}
