//! `shaders/bsdf/` in f64.
#![expect(
    clippy::module_inception,
    reason = "the modules have the names of the shader files"
)]

pub mod bsdf;
pub mod compensation;
pub mod fresnel;
pub mod ggx;
pub mod lambert;
pub mod specular;
