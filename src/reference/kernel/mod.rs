//! `shaders/kernel/` in f64.

pub mod camera;
pub mod direct;
