//! Progressive rendering: passes on the GPU, blocks of samples merged into an f64 film on the host.

mod adaptive;
pub mod aov;
mod cache_buster;
pub mod check;
mod error;
pub mod film;
pub mod goal;
pub mod memory;
mod neighbourhood;
pub mod passes;
mod recover;
mod scouts;
pub mod session;

pub use aov::{AovImages, render_aovs};
pub use cache_buster::CacheBuster;
pub use check::Check;
pub use error::{CONFIDENCE, Doubt, ImageError, StatedError, tile_sums};
pub use film::{Film, FirstBad, Ledger, Pixel};
pub use goal::ErrorGoal;
pub use passes::{Passes, StoppedBy};
pub use recover::{Failure, render_keeping_image, render_through_losses};
pub use session::checkpoint::Checkpoint;
pub use session::{RayCounts, Session, StopReason};
