//! All integration tests, as one binary: linking wgpu once instead of a dozen times.
//!
//! They need a GPU adapter; lavapipe will do. Without one they fail, they are never skipped.

mod cli;
mod doctor;
mod layout;
mod permutations;
mod render;
mod scene;
mod support;
