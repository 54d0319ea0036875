//! One file per file of `shaders/kernel/`.

mod accumulate;
mod camera;
mod camera_path;
mod direct;
mod feature_record;
mod filter;
mod gbuffer;
mod lab_bindings;
mod lab_discrete;
mod lab_estimators;
mod lab_importance;
mod lab_pi;
mod lab_quadrature;
mod lab_sampling;
mod light_groups;
mod loop_canary;
mod record;
mod sample_record;
mod shadow_rays;
