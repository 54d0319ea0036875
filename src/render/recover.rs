//! Renders that outlive their device.

use super::prepare::Prepared;
use super::session::Session;
use super::session::checkpoint::Checkpoint;
use crate::error::{Error, GpuError};
use crate::gpu::Context;

/// Losses at the same number of samples after which there is no point in another try.
const PATIENCE: u32 = 3;

/// Lets `work` render `prepared`, with its own size and seed, on a device that `open` gives. When the device is lost, `lost`
/// is told why and how many samples per pixel are safe, and `work` goes on with those on another device; the image is the
/// one that an unbroken render on the same driver would have given, bit for bit.
///
/// # Errors
/// `work` or `open` fails, or devices are lost again and again without a sample between.
pub fn render_through_losses<T>(
    mut open: impl FnMut() -> Result<Context, GpuError>,
    prepared: &Prepared,
    mut work: impl FnMut(&mut Session<'_>) -> Result<T, Error>,
    mut lost: impl FnMut(&GpuError, u64),
) -> Result<T, Error> {
    let scene = &prepared.scene;
    let mut checkpoint: Option<Checkpoint> = None;
    let mut in_vain = 0;
    loop {
        let context = open()?;
        let mut session = Session::new(&context, prepared, scene.film, scene.render.seed)?;
        let before = checkpoint.as_ref().map_or(0, Checkpoint::samples);
        if let Some(checkpoint) = checkpoint.take() {
            session.resume(checkpoint)?;
        }
        match work(&mut session) {
            Err(Error::Gpu(error @ GpuError::Lost { .. })) => {
                let safe = session.into_checkpoint();
                in_vain = if safe.samples() > before {
                    0
                } else {
                    in_vain + 1
                };
                if in_vain == PATIENCE {
                    return Err(error.into());
                }
                lost(&error, safe.samples());
                checkpoint = Some(safe);
            }
            done => return done,
        }
    }
}
