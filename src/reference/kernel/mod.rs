//! `shaders/kernel/` in f64.

pub mod camera;
pub mod camera_path;
pub mod direct;
pub mod filter;
pub mod sample;
pub mod shadow_rays;
