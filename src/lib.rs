//! direkt: direct lighting by Monte Carlo integration.
pub mod error;
pub mod scene;
