//! direkt renders direct lighting by Monte Carlo integration in WGSL compute shaders, through wgpu,
//! on any GPU and on none (Mesa lavapipe is Vulkan in software).
//!
//! ```text
//!     L_o(x,ω_o) = L_e + ∫_H L_i(x,ω) f_r(x,ω,ω_o) cosθ dω                 hemisphere form
//!                = L_e + ∫_A L_e(y→x) f_r V(x,y) cosθ_x cosθ_y/|x−y|² dA    area form
//! ```
//!
//! # The way of the data
//!
//! ```text
//! scene file ─► scene::load ─► Scene (f64, validated)
//!                                │
//!                                ▼
//!               prepare::SceneData: scene::normalize (recentre, power-of-two scale), accel (BVH)
//!                                │             what depends on the scene alone; estimators share it
//!                                ▼
//!               prepare::Prepared: emitters (lights, selection), effects (what is compiled in, and why)
//!                                │             what depends on the estimator as well
//!                                ▼
//!               gpu::GpuScene (uploaded once), gpu::SceneBuffers, gpu::shader::link (WESL → WGSL), gpu::SceneKernel
//!                                │             a small scene is part of the kernel: gpu::specialize
//!                                │
//!                                ▼
//!               render::Session: passes ─► blocks of 256 samples ─► Film (f64) ─► image::{exr, png}
//!                                │
//!                                ▼
//!               renderer::Renderer: all of it in one call
//! ```
//!
//! One direction only: `scene ← accel ← emitters ← effects ← prepare ← gpu ← render ← image ←
//! renderer`; a test holds these layers (`tests/layers.rs` has the table). Beside `gpu`, and
//! without it, [`low_level::reference`] computes in f64 what samples should be, and
//! [`low_level::stats`] decides whether they are.
//!
//! This package is the core: no window, no command line, no plots. Above it stand, as packages that
//! the compiler keeps apart:
//!
//! | package | holds |
//! |---|---|
//! | `crates/instruments` | `compare`, `cost`, `explain`, `lab`; plots (`drawing`) and reports of them |
//! | `crates/window` | the preview window |
//! | `crates/cli` | the command `direkt`, and the tests of all (`tests/suite.rs`) |
//!
//! # A render, from code
//!
//! ```no_run
//! use direkt::{LoadOptions, Renderer, Scene};
//!
//! let scene = Scene::load("scenes/cornell.toml", &LoadOptions::default())?;
//! let image = Renderer::new()?.render(scene)?;
//! println!("mean {:?}, error {:?}", image.mean(), image.error());
//! image.write("cornell.exr")?;
//! # Ok::<(), direkt::Error>(())
//! ```
//!
//! `examples/` has more: `scene_in_code`, `embed_wgpu` (the caller's device and texture),
//! `compare_estimators` and `own_sampler`. Most programs need no more than what stands at the root
//! of this crate, and [`scene`]; [`low_level`] is what that is made of.
//!
//! # What holds everywhere
//!
//! - **Host f64, GPU f32.** The scene is moved to the origin and scaled to [−1, 1] in f64 before
//!   anything is rounded; one that is much larger than what is in view is centred there
//!   ([`scene::normalize`]).
//! - **Random numbers are counters**: a hash of (pixel, sample, dimension, seed), integers that are
//!   the same on every device. Dimensions are assigned once for all, so an unneeded effect
//!   changes no bit.
//! - **An image does not depend on how its passes were cut**: a pixel's state goes on exactly from
//!   where it stood, and blocks end at multiples of 256 samples.
//! - **A sample that is not finite is dropped and counted**, with the first pixel and sample of
//!   each kind; it is never shown.
//! - **A driver that ends loops early is noticed**: the kernel tells when a traversal did not
//!   finish, and the host dispatches again from there.
//!
//! # How to add
//!
//! - **an effect**: an entry in the table of [`low_level::effects`] with its WESL feature, name and
//!   the rule that calls for it; the code under `@if(FEATURE)` in a file of `shaders/`, its twin in
//!   the file of the same name of [`low_level::reference`], its test in the file of the same name
//!   of `tests/shader/`, and a scene of it in `scenes/tests/`. Everything else follows from the
//!   entry: `tests/permutations.rs` links it alone, `explain` tells of it, `compare` compares it.
//!   Depth of field, for example, is
//!
//!   ```text
//!   src/effects/mod.rs                DepthOfField "DEPTH_OF_FIELD" "depth-of-field" Simulation
//!                                     |r| r.depth_of_field();
//!   shaders/kernel/camera.wesl        @if(DEPTH_OF_FIELD) { … frame.camera.lens_right … }
//!   src/reference/kernel/camera.rs    the same in f64
//!   tests/shader/kernel/camera.rs     GPU against twin, ray by ray
//!   scenes/tests/thin_lens_blur.toml  a disk out of focus, and the exact value of its blur
//!   ```
//!
//!   An effect that reads new data adds it to [`scene`] with its loader, and a member of `Frame` or
//!   a buffer.
//! - **a setting of the estimator**: a field in `render_table!` of `src/scene/settings.rs`, which
//!   makes its key in scene files, its flag, and its places in JSON, EXR files and saved scenes;
//!   the rule of the effect that it calls for; and its control in
//!   `crates/window/src/panels/estimator.rs`.
//! - **a light without a surface**: a spot light is in these files; those that are not named after
//!   it have one line or one case of it:
//!
//!   ```text
//!   src/scene/lights/spot.rs           its data, keys in a scene file, checks, power, spread, record
//!   src/scene/lights/mod.rs            its row in the table of kinds
//!   src/effects/mod.rs                 its effect, LIGHT_SPOTS
//!   shaders/light/spot.wesl            sample_spot_light
//!   shaders/light/light.wesl           its case
//!   src/reference/light/spot.rs        the same in f64, which reads nothing of the record
//!   src/reference/light/mod.rs         its module
//!   src/reference/light/light.rs       its case
//!   tests/shader/light/, scenes/tests/ GPU against twin, and a scene with an exact value
//!   ```
//!
//!   `tests/homes.rs` holds this list. Numbers for the fuzz test are made in
//!   `examples/fuzz/harness/numbers.rs`. A light that BSDF-sampled rays reach as well, such as a
//!   sun, also needs its density in `shaders/kernel/direct.wesl`.
//! - **a shape that emits**: its case in `shaders/light/area_light.wesl` and
//!   `shaders/scene/fetch.wesl`, its `sample_` and `pdf_` functions in a file of `shaders/light/`,
//!   their twins, its bounds in [`low_level::emitters::tree`], and its effect.
//! - **a BSDF**: a variant of [`scene::Bsdf`]; if it is not a case of the existing lobes, its
//!   `sample_`, `pdf_` and `eval_` in `shaders/bsdf/` and its place in `shaders/bsdf/bsdf.wesl`, or
//!   in `shaders/bsdf/specular.wesl` where camera rays go on in it.
//! - **an AOV**: a variant of [`scene::Aov`], what it is made of in [`low_level::render::aov`] or
//!   in the film, its channels in [`low_level::image::layers`], and its row in `docs/aov.md`.
//!
//! # What is awkward today
//!
//! - Glass passes no shadow rays, so that its shadows are black; transmission is smooth, and bodies
//!   do not absorb.
//! - Lights with an opacity are chosen as often as opaque ones.
//! - The BVH's boxes lie on one 16-bit grid over the scene: where detail is finer than 1/65,535 of
//!   the scene's size, boxes are looser than they need be. In scenes more than 4,096 times as large
//!   as what is in view the grid is logarithmic and the eye its centre; spheres as large as that
//!   are warned of, not cut.
//! - Geometry that exceeds a binding (128 MiB on lavapipe: 2.8 million triangles) is split over
//!   several. Such kernels take six times as long to compile.

#![deny(clippy::print_stdout, clippy::print_stderr)]
#![warn(unnameable_types, unreachable_pub)]

pub mod error;
mod lattice;
pub mod low_level;
mod renderer;
pub mod scene;

use low_level::{
    accel, console, effects, emitters, gpu, image, output, prepare, reference, render, stats,
};

pub use error::Error;
pub use render::{Film, ImageError, StatedError, StoppedBy};
pub use renderer::{Image, ProgressiveRender, Renderer};
pub use scene::load::LoadOptions;
pub use scene::{
    Bsdf, Camera, DirectionalLight, Emission, Environment, EnvironmentRadiance, ErrorMetric,
    EstimatorSettings, FilmSize, Geometry, Light, LightSampling, LightSelection, Material,
    MaterialId, Mesh, PointLight, Projection, RenderSettings, Sampler, Scene, Shape, SpotLight,
    StopSettings, Strategy, SunLight,
};
