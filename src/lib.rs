//! direkt: direct lighting by Monte Carlo integration.
pub mod accel;
pub mod effects;
pub mod emitters;
pub mod error;
pub mod gpu;
pub mod render;
pub mod scene;
