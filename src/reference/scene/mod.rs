//! `shaders/scene/` in f64: the scene as the reference holds it.

pub mod attributes;
pub mod fetch;
pub mod opacity;
pub mod surface;
pub mod texture;
pub mod textured;
pub mod trace;
