//! One file per file of `shaders/bsdf/`.

mod lambert;
