//! Files that are written: probed before work begins, replaced as a whole, and saved elsewhere
//! where that fails.
//!
//! A file is written under a temporary name in its folder and renamed, so that a reader sees the
//! old file or the whole new one. Symbolic links are followed, as `cp` does: the link stays and its
//! target is replaced, with the permissions that it had.

mod destination;
mod identity;
mod probe;
mod temporary;
mod write;

pub use destination::Destination;
pub use identity::Identity;
pub use probe::{probe, probe_folder};
pub use write::{rescue_folder, save_elsewhere, write, write_or_save_elsewhere};
