//! Closed forms and quadrature for a single receiver: what a pixel must be, to ten digits and more.
//!
//! Every configuration factor is F = E/(πL): the irradiance E at the receiver, over what a
//! hemisphere of the light's radiance L would give. A Lambertian surface of reflectance ρ then
//! shows the radiance ρ·L·F. All is in f64 and in the scene's own units; but for [`mod@scene`],
//! which looks at a whole scene, nothing here knows of the renderer.

mod cap;
pub mod cubature;
pub mod direct;
pub mod disk;
mod domain;
pub mod ellipsoid;
pub mod fresnel;
pub mod ggx;
pub mod lecture;
pub mod occlusion;
pub mod point;
pub mod polygon;
pub mod rectangle;
pub mod scene;
pub mod solid_angle;
pub mod sphere;
pub mod variance;

#[cfg(test)]
mod tests;
