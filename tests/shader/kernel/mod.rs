//! One file per file of `shaders/kernel/`.

mod accumulate;
mod camera;
mod direct;
mod loop_canary;
mod record;
mod sample_record;
