//! Images on disk: EXR with the error beside the radiance, PNG through a tone mapper.

pub mod exr;
pub mod heat;
pub mod layers;
pub mod png;
pub mod signed;
pub mod tone;

use std::path::Path;

pub use tone::ToneMapper;

/// A file name's extension in lower case; empty where there is none.
pub fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.unwrap_or_default().to_lowercase()
}
