//! `shaders/scene/` in f64: the scene as the reference holds it.

pub mod fetch;
pub mod surface;
pub mod trace;
