//! One file per file of `shaders/kernel/`.
