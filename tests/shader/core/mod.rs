//! One file per file of `shaders/core/`.
