//! What the GPU is held against: the estimator in f64, and exact answers.
//!
//! - The *twin*, [`Twin`], mirrors each file and function of `shaders/` in f64. Fed the same random
//!   integers it must agree sample by sample; fed others, on average. It has its own hierarchy and
//!   its own ray–primitive tests, and writes densities as the papers do.
//! - [`broken`]: twins with one mistake each, which every check has to reject.
//! - [`exact`]: closed forms and quadrature with an error bound.
//!
//! What the twin does share with the renderer is the host's part of a scene: the parsed file, the
//! normalisation, the list of lights with their selection probabilities, the light tree. Mistakes
//! there are caught by exact values alone.

pub mod broken;
pub mod bsdf;
pub mod core;
pub mod exact;
pub mod kernel;
pub mod light;
pub mod scene;
pub mod twin;

pub use broken::BrokenTwin;
pub use kernel::direct::Direct;
pub use kernel::sample::{BsdfRay, Conditions, Path, Sample, Shadow};
pub use twin::Twin;
