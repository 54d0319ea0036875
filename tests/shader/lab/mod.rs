//! One file per file of `shaders/lab/`; the structs of `types.wesl` are compared in
//! `tests/layout.rs`.

mod circle;
mod densities;
mod estimators;
mod integrands;
mod linear;
mod rules;
mod welford;
