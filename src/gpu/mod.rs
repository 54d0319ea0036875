//! Everything that touches wgpu: the device, shader linking, buffers, kernels.

pub mod buffer;
pub mod context;
pub mod doctor;
mod environment;
pub mod features;
mod frame;
mod gpu_scene;
pub mod kernel;
mod kernels;
pub mod layout;
mod lights;
mod materials;
mod parts;
pub mod program;
pub mod recorder;
pub mod scene_buffers;
pub mod shader;
pub mod specialize;
pub mod textures;
pub mod tiles;

pub use buffer::GpuBuffer;
pub use context::{AdapterFacts, Context};
pub use frame::frame_of;
pub use gpu_scene::GpuScene;
pub use kernel::SceneKernel;
pub use parts::Parts;
pub use scene_buffers::SceneBuffers;
