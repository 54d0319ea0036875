//! `shaders/kernel/` in f64.

mod bsdf_rays;
pub mod camera;
pub mod camera_path;
pub mod direct;
pub mod feature_record;
pub mod filter;
pub mod gbuffer;
mod lights_in_view;
pub mod sample;
pub mod shadow_rays;
