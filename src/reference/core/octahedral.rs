//! Unit vectors in two numbers; see `shaders/core/octahedral.wesl`. What is encoded is decoded in
//! one place.

pub use crate::accel::octahedral::from_octahedral;
