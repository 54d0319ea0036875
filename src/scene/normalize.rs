//! Moves and scales a scene for f32.
