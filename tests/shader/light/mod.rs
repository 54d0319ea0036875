//! One file per file of `shaders/light/`.

mod disk;
