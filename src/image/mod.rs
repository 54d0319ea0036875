//! Images on disk: EXR with the error beside the radiance, PNG through a tone mapper.

pub mod exr;
pub mod heat;
pub mod layers;
pub mod png;
pub mod signed;
pub mod tone;

use crate::error::Error;
use std::io::Write;
use std::path::Path;

pub use tone::ToneMapper;

/// A file name's extension in lower case; empty where there is none.
pub fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.unwrap_or_default().to_lowercase()
}

/// Writes a file under a temporary name in the same folder and renames it: a reader sees the old file or the whole
/// new one, and a failure leaves the old one as it was.
///
/// # Errors
/// The folder or the file cannot be written.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let fail = |source| Error::Write {
        path: path.to_path_buf(),
        source,
    };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".direkt-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(fail)?;
    file.write_all(bytes).map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}
