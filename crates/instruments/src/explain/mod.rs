//! What a scene's render is made of, and what each effect costs.
//!
//! | part | what it tells |
//! |---|---|
//! | [`shader`] | size of the kernel: WGSL, functions, instructions of SPIR-V |
//! | [`memory`] | bytes of every buffer and texture |
//! | [`sample`] | rays and random numbers of one sample |
//! | [`price`] | measured: compile time and time per sample, with each further effect compiled in and with all of them |

pub mod aov;
pub mod memory;
pub mod plot;
pub mod price;
pub mod sample;
pub mod shader;
