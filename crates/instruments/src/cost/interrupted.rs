//! Why measuring ends early.

use direkt::error::{Error, GpuError};

/// Why there is no result.
#[derive(Debug)]
pub enum Interrupted {
    /// The caller asked to stop.
    Stopped,
    /// Something failed.
    Failed(Error),
}

impl From<Error> for Interrupted {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

impl From<GpuError> for Interrupted {
    fn from(error: GpuError) -> Self {
        Self::Failed(error.into())
    }
}
