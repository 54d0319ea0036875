//! One file per file of `shaders/light/`.
#![expect(
    clippy::module_inception,
    reason = "the modules have the names of the shader files"
)]

mod disk;
mod light;
