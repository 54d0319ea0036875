//! One file per file of `shaders/bsdf/`.
#![expect(
    clippy::module_inception,
    reason = "the modules have the names of the shader files"
)]

mod bsdf;
mod compensation;
mod fresnel;
mod ggx;
mod lambert;
mod specular;
