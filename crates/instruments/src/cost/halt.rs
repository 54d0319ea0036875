//! Why measuring ends early.

use direkt::error::{Error, GpuError};

/// Why there is no result.
#[derive(Debug)]
pub enum Halt {
    /// The caller asked to stop.
    Stopped,
    /// Something failed.
    Failed(Error),
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

impl From<GpuError> for Halt {
    fn from(error: GpuError) -> Self {
        Self::Failed(error.into())
    }
}
