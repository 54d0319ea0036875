//! All integration tests, as one binary: linking wgpu once instead of a dozen times.
//!
//! They need a GPU adapter; lavapipe will do. Without one they fail, they are never skipped.

#![allow(
    clippy::unwrap_used,
    reason = "a test that panics is a test that fails"
)]
#![allow(clippy::float_cmp, reason = "tests of invariance compare bit for bit")]

mod cli;
mod compare;
mod cost;
mod doctor;
mod hard_cases;
mod homes;
mod lab;
mod layers;
mod layout;
mod permutations;
mod render;
mod renderer;
mod scene;
mod shader;
mod support;
#[cfg(feature = "window")]
mod window;
