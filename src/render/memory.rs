//! The memory that an image takes on the host, and what there is.

use super::film::Pixel;
use crate::error::GpuError;
use crate::gpu::layout::{GroupMean, PixelState};
use crate::gpu::{Context, SceneBuffers};
use crate::prepare::Prepared;
use crate::scene::FilmSize;
use crate::scene::load::Capacity;

/// Numbers of three channels per pixel that judging the image's error holds at once.
const ERROR_TRIPLES: u64 = 13;
/// Bytes per triangle while the hierarchy over a mesh is built and uploaded. Of a mesh of ten
/// million, read from a PLY file, 383 were measured; normals, texture coordinates and what else is
/// in memory take more.
const TRIANGLE_BYTES: u64 = 512;
/// Channels per pixel that an EXR is written from.
const CHANNELS: u64 = 8;

/// Bytes of the film, of the copy of it that is looked at, and of what is computed from that, for
/// an image of `size`; adaptive sampling has a pilot's film beside.
pub fn host_bytes(prepared: &Prepared, size: FilmSize) -> u64 {
    let groups = prepared.emitters.groups.names.len();
    let triple = size_of::<[f64; 3]>() as u64;
    let film = size_of::<Pixel>() as u64 + groups as u64 * triple;
    let films = 2 + u64::from(prepared.settings.estimator.adaptive);
    let of_pixel = films * film + ERROR_TRIPLES * triple + CHANNELS * size_of::<f32>() as u64;
    size.pixels() as u64 * of_pixel
}

/// Bytes of the pixels' states on the device, and of what they are read back through.
fn device_bytes(size: FilmSize, groups: usize) -> u64 {
    let state = size_of::<PixelState>() + groups * size_of::<GroupMean>();
    size.pixels() as u64 * (2 * state + 2 * size_of::<u32>()) as u64
}

/// Checks that an image of `size`, and what is uploaded of `prepared`, fit the memory of the host;
/// that of a device in software is the same memory.
///
/// # Errors
/// It does not.
pub(super) fn check(
    context: &Context,
    prepared: &Prepared,
    size: FilmSize,
) -> Result<(), GpuError> {
    let on_device = if context.adapter.software {
        let groups = prepared.emitters.groups.names.len();
        let scene = SceneBuffers::sizes(prepared).into_iter();
        device_bytes(size, groups) + scene.map(|(_, bytes)| bytes).sum::<u64>()
    } else {
        0
    };
    let needed = host_bytes(prepared, size) + on_device;
    match available() {
        Some(available) if needed > available => Err(GpuError::TooLittleMemory {
            what: format!(
                "an image of {} × {} pixels of {} primitives",
                size.width,
                size.height,
                prepared.data.primitives.len()
            ),
            needed,
            available,
        }),
        _ => Ok(()),
    }
}

/// Most triangles of which the memory that is available holds what is read and built; `None` where
/// the system does not tell.
pub fn capacity() -> Option<Capacity> {
    let available = available()?;
    Some(Capacity {
        triangles: available / TRIANGLE_BYTES,
        reason: format!(
            "which is what the {available} bytes of memory hold that are available, at {TRIANGLE_BYTES} each"
        ),
    })
}

/// Bytes that this process may still take: what the machine has left, its control group and its
/// limit of address space. `None` where the system does not tell.
fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let kibibytes = |path: &str, key: &str| Some(1024 * number_after(&read(path)?, key)?);
    let machine = kibibytes("/proc/meminfo", "MemAvailable:");
    let address_space = || {
        let limit = number_after(&read("/proc/self/limits")?, "Max address space")?;
        Some(limit.saturating_sub(kibibytes("/proc/self/status", "VmSize:")?))
    };
    let control_group = || {
        let number = |name: &str| {
            let text = read(&format!("/sys/fs/cgroup/memory.{name}"))?;
            text.trim().parse::<u64>().ok()
        };
        Some(number("max")?.saturating_sub(number("current")?))
    };
    let limits = [machine, address_space(), control_group()];
    limits.into_iter().flatten().min()
}

/// The number behind `key`, at the start of a line; `None` where there is none, as for `unlimited`.
fn number_after(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_behind_their_keys() {
        let text = "MemTotal:  100 kB\nMemAvailable:   4096 kB\n";
        assert_eq!(number_after(text, "MemAvailable:"), Some(4096));
        let limits = "Max address space         unlimited            unlimited            bytes";
        assert_eq!(number_after(limits, "Max address space"), None);
        assert_eq!(number_after(text, "SwapFree:"), None);
    }
}
