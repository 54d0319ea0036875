//! Progressive rendering: passes on the GPU, blocks of samples merged into an f64 film on the host.

pub mod check;
pub mod film;
pub mod prepare;
pub mod session;

pub use check::Check;
pub use film::{Film, FirstBad, ImageError, Ledger};
pub use prepare::{Patterns, Prepared};
pub use session::{RayCounts, Session, StopReason};
