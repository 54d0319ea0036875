//! What [`Renderer`](crate::Renderer) is made of, for instruments, tests and programs that need a
//! part of it. It changes without notice.

#[path = "accel/mod.rs"]
pub mod accel;
#[path = "console.rs"]
pub mod console;
#[path = "effects/mod.rs"]
pub mod effects;
#[path = "emitters/mod.rs"]
pub mod emitters;
#[path = "gpu/mod.rs"]
pub mod gpu;
#[path = "image/mod.rs"]
pub mod image;
#[path = "output/mod.rs"]
pub mod output;
#[path = "prepare/mod.rs"]
pub mod prepare;
#[path = "reference/mod.rs"]
pub mod reference;
#[path = "render/mod.rs"]
pub mod render;
#[path = "stats/mod.rs"]
pub mod stats;
