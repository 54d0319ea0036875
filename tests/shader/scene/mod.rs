//! One file per file of `shaders/scene/`.
