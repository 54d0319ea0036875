//! The window: a scene, the estimator that renders it, and its error while it falls.
//!
//! Two threads share a mailbox. The window's own draws controls and pictures, and posts a request
//! whenever something changes: camera, size, method, lights. The renderer's works off the newest
//! request, on a device of its own, and posts pictures. So the window answers while a kernel is
//! compiled or a long dispatch runs, and losing one device does not lose the other. A pixel's state
//! stays on the renderer's device; what is copied is a picture now and then, as often as takes a
//! fiftieth of the time.

mod app;
mod canvas;
mod curve;
mod density;
mod files;
mod latency;
mod lights;
mod mailbox;
mod navigation;
mod panels;
mod picture;
mod render_thread;
mod renderer;
mod request;
mod save;
mod view;
mod watch;

use direkt::error::Error;
use direkt::low_level::gpu::context::matches;
use direkt::scene::Scene;
use direkt::scene::load::LoadOptions;
use eframe::egui;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// What the window is opened with.
#[derive(Debug, Clone)]
pub struct Options {
    /// The scene file.
    pub path: PathBuf,
    /// The files that it was read from.
    pub files: BTreeSet<PathBuf>,
    /// How it and those that are dropped on the window are read.
    pub load: LoadOptions,
    /// Part of the adapter's name; none for the best.
    pub adapter: Option<String>,
    /// Size of the image in the beginning, in pixels of the screen.
    pub size: [u32; 2],
    /// Whether what happens is told on stderr.
    pub verbose: bool,
}

/// Opens the window on `scene` and returns when it is closed.
///
/// # Errors
/// There is no display or no adapter that draws on it.
pub fn run(scene: Scene, options: Options) -> Result<(), Error> {
    let [width, height] = options.size.map(|side| side as f32);
    let size = [width + panels::WIDTH, height];
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("direkt")
            .with_app_id("direkt")
            .with_inner_size(size)
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: wgpu_options(options.adapter.clone()),
        ..Default::default()
    };
    let source = options.path.display().to_string();
    eframe::run_native(
        "direkt",
        native,
        Box::new(|creation| Ok(Box::new(app::App::new(creation, scene, options)))),
    )
    .map_err(|error| no_window(&source, &error))
}

/// Draws on the adapter that renders.
fn wgpu_options(adapter: Option<String>) -> eframe::egui_wgpu::WgpuConfiguration {
    use eframe::egui_wgpu::{SurfaceConfig, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::PRIMARY;
    if let Some(wanted) = adapter {
        setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
            let draws = |a: &&wgpu::Adapter| surface.is_none_or(|s| a.is_surface_supported(s));
            let mut fitting = adapters.iter().filter(|a| matches(a, &wanted));
            let found = fitting.find(draws).cloned();
            found.ok_or_else(|| format!("no adapter `{wanted}` draws on this display"))
        }));
    }
    WgpuConfiguration {
        wgpu_setup: WgpuSetup::CreateNew(setup),
        ..Default::default()
    }
    .with_surface_config(SurfaceConfig {
        present_mode: wgpu::PresentMode::AutoNoVsync,
        ..SurfaceConfig::LOW_LATENCY
    })
}

fn no_window(scene: &str, error: &eframe::Error) -> Error {
    Error::Usage(format!(
        "no window can be opened here ({error}); `direkt render {scene} -o image.png` needs none"
    ))
}

/// A scene of the project.
#[cfg(test)]
fn example(name: &str) -> PathBuf {
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    std::path::Path::new(scenes).join(format!("{name}.toml"))
}
