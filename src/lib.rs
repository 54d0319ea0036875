//! direkt: direct lighting by Monte Carlo integration.
pub mod accel;
pub mod cli;
pub mod effects;
pub mod emitters;
pub mod error;
pub mod gpu;
pub mod image;
pub mod render;
pub mod scene;
