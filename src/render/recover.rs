//! Renders that outlive their device.

use super::film::Film;
use super::session::checkpoint::Checkpoint;
use super::session::{RayCounts, Session};
use crate::error::{Error, GpuError};
use crate::gpu::Context;
use crate::prepare::Prepared;

/// Losses at the same number of samples after which there is no point in another try.
const PATIENCE: u32 = 3;

/// What can be gone on with, and the same as an image.
type Safe = (Checkpoint, (Film, RayCounts));

/// A render that failed.
#[derive(Debug)]
pub struct Failure {
    /// Why.
    pub error: Error,
    /// The image so far, and the rays traced for it; none while there is no sample of it on the
    /// host.
    pub image: Option<Box<(Film, RayCounts)>>,
}

impl Failure {
    fn new(error: impl Into<Error>, image: Option<(Film, RayCounts)>) -> Self {
        Self {
            error: error.into(),
            image: image.filter(|(_, rays)| rays.camera > 0).map(Box::new),
        }
    }
}

/// Lets `work` render `prepared`, with its own size and seed, on a device that `open` gives. When
/// the device is lost, `lost` is told why and how many samples per pixel are safe, and `work` goes
/// on with those on another device; the image is the one that an unbroken render on the same driver
/// would have given, bit for bit.
///
/// # Errors
/// `work` or `open` fails, or devices are lost again and again without a sample between.
pub fn render_through_losses<T>(
    open: impl FnMut() -> Result<Context, GpuError>,
    prepared: &Prepared,
    work: impl FnMut(&mut Session<'_>) -> Result<T, Error>,
    lost: impl FnMut(&GpuError, u64),
) -> Result<T, Error> {
    render_keeping_image(open, prepared, work, lost).map_err(|failure| failure.error)
}

/// Like [`render_through_losses`], with the image so far where it fails.
///
/// # Errors
/// `work` or `open` fails, or devices are lost again and again without a sample between.
pub fn render_keeping_image<T>(
    mut open: impl FnMut() -> Result<Context, GpuError>,
    prepared: &Prepared,
    mut work: impl FnMut(&mut Session<'_>) -> Result<T, Error>,
    mut lost: impl FnMut(&GpuError, u64),
) -> Result<T, Failure> {
    let (film, seed) = (prepared.film, prepared.settings.seed);
    let mut safe: Option<Safe> = None;
    let mut in_vain = 0;
    loop {
        let image = |safe: Option<Safe>| safe.map(|(_, image)| image);
        let context = match open() {
            Ok(context) => context,
            Err(error) => return Err(Failure::new(error, image(safe))),
        };
        let mut session = match Session::new(&context, prepared, film, seed) {
            Ok(session) => session,
            Err(error) => return Err(Failure::new(error, image(safe))),
        };
        let before = safe.as_ref().map_or(0, |(c, _)| c.samples());
        if let Some((checkpoint, image)) = safe.take()
            && let Err(error) = session.resume(checkpoint)
        {
            return Err(Failure::new(error, Some(image)));
        }
        match work(&mut session) {
            Ok(done) => return Ok(done),
            Err(Error::Gpu(error @ GpuError::Lost { .. })) => {
                let image = session.safe_image();
                let checkpoint = session.into_checkpoint();
                in_vain = if checkpoint.samples() > before {
                    0
                } else {
                    in_vain + 1
                };
                if in_vain == PATIENCE {
                    return Err(Failure::new(error, Some(image)));
                }
                lost(&error, checkpoint.samples());
                safe = Some((checkpoint, image));
            }
            Err(error) => {
                let image = session.snapshot();
                let image = image.unwrap_or_else(|_| session.safe_image());
                return Err(Failure::new(error, Some(image)));
            }
        }
    }
}
