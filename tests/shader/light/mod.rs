//! One file per file of `shaders/light/`.
#![expect(
    clippy::module_inception,
    reason = "the modules have the names of the shader files"
)]

mod alias_table;
mod area_light;
mod disk;
mod ellipsoid;
mod emission;
mod environment;
mod light;
mod opacity;
mod polygon;
mod rectangle;
mod seen;
mod sphere;
mod spot;
mod sun;
mod tree;
mod triangle;
