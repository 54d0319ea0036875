//! One file per file of `shaders/core/`.

mod bvh;
mod constants;
mod frame;
mod math;
mod octahedral;
mod pdf;
mod ray;
mod ray_ellipsoid;
mod ray_planar;
mod ray_sphere;
mod rng;
mod sampler;
mod sobol;
mod stratified;
