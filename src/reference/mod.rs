//! What a renderer should compute, by other means than the renderer's, in f64 on the host.

pub mod exact;
