//! `shaders/light/` in f64.
#![expect(
    clippy::module_inception,
    reason = "the modules have the names of the shader files"
)]

pub mod alias_table;
pub mod area_light;
pub mod directional;
pub mod disk;
pub mod ellipsoid;
pub mod emission;
pub mod environment;
pub mod light;
pub mod opacity;
pub mod point;
pub mod polygon;
pub mod rectangle;
pub mod sample;
pub mod sphere;
pub mod spot;
pub mod sun;
pub mod tree;
pub mod triangle;
