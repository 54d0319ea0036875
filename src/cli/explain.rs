//! `direkt explain`: which effects a scene calls for, and why.

use super::settings::{AssetArguments, EstimatorArguments};
use super::{JsonArgument, print};
use crate::effects::Effect;
use crate::error::Error;
use crate::gpu::shader::{self, Config};
use crate::render::Prepared;
use crate::scene::load::schema;
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
    #[command(flatten)]
    assets: AssetArguments,
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
    environment: Option<EnvironmentSampling>,
    mis_compensation_unused: Option<String>,
    biased: Option<String>,
    warnings: Vec<String>,
}

/// How directions towards the environment map are chosen.
#[derive(Debug, Serialize)]
struct EnvironmentSampling {
    columns: u32,
    rows: u32,
    compensated: bool,
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
    let mut scene = arguments.assets.load(path)?;
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
        environment: environment_sampling(&prepared),
        mis_compensation_unused: mis_compensation_unused(&prepared),
        biased: prepared.bias(),
        warnings: prepared.scene.warnings.clone(),
    };
    arguments.json.write(&report)?;
    if !arguments.json.is_stdout() {
        print(&text(&report))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn environment_sampling(prepared: &Prepared) -> Option<EnvironmentSampling> {
    let grid = prepared.emitters.environment.as_ref()?;
    let sampled = prepared.scene.render.strategy.samples_lights();
    sampled.then_some(EnvironmentSampling {
        columns: grid.size[0],
        rows: grid.size[1],
        compensated: grid.compensated,
    })
}

/// Why `mis_compensation`, which is asked for, changes nothing.
fn mis_compensation_unused(prepared: &Prepared) -> Option<String> {
    let settings = prepared.scene.render;
    if !settings.mis_compensation {
        return None;
    }
    match &prepared.emitters.environment {
        None => Some("the scene has no environment map that emits".to_owned()),
        Some(_) if !settings.strategy.is_mis() => Some(format!(
            "strategy {} does not combine light and BSDF sampling",
            settings.strategy
        )),
        Some(grid) => (!grid.compensated).then(|| "the environment map is constant".to_owned()),
    }
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
    if let Some(grid) = &report.environment {
        let by = if grid.compensated {
            "what of its luminance exceeds the mean (mis_compensation)"
        } else {
            "its luminance"
        };
        let _ = writeln!(
            out,
            "a direction towards the environment map is chosen among {} × {} cells, each by {by}",
            grid.columns, grid.rows
        );
    }
    if let Some(reason) = &report.mis_compensation_unused {
        let _ = writeln!(out, "mis_compensation changes nothing: {reason}");
    }
    for warning in report.biased.iter().chain(&report.warnings) {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}
