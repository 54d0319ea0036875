//! The shaders' functions on the GPU against their twins in f64: one file per file of `shaders/`.

mod bsdf;
mod core;
mod kernel;
mod lab;
mod light;
mod scene;
