//! `shaders/core/` in f64.

pub mod bvh;
pub mod frame;
pub mod math;
pub mod octahedral;
pub mod pdf;
pub mod ray;
pub mod ray_ellipsoid;
pub mod ray_planar;
pub mod ray_sphere;
pub mod rng;
pub mod sampler;
pub mod sobol;
pub mod stratified;
