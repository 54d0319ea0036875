//! What a render holds on the device and on the host.

use direkt::low_level::effects::Effect;
use direkt::low_level::gpu::SceneBuffers;
use direkt::low_level::gpu::layout::{Dispatch, Frame, GroupMean, PixelState, TILE, TILE_PIXELS};
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::memory::host_bytes;
use direkt::scene::FilmSize;
use serde::Serialize;

/// A buffer or texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Its label.
    pub name: &'static str,
    /// Its size.
    pub bytes: u64,
}

/// Every buffer and texture of a render of `prepared` at `film` pixels.
pub fn of(prepared: &Prepared, film: FilmSize) -> Vec<Memory> {
    let tiles = u64::from(film.width.div_ceil(TILE)) * u64::from(film.height.div_ceil(TILE));
    let pixels = tiles * u64::from(TILE_PIXELS) * size_of::<PixelState>() as u64;
    let word = size_of::<u32>() as u64;
    let host = host_bytes(prepared, film);
    let of_image = [
        ("direct.pixels", pixels),
        ("direct.pixels.staging", pixels),
        ("direct.order", tiles * u64::from(TILE_PIXELS) * word),
        ("film", host),
        ("direct.frame", size_of::<Frame>() as u64),
        ("direct.dispatch", size_of::<Dispatch>() as u64),
        ("direct.unfinished", word),
        ("direct.unfinished.staging", word),
    ];
    let groups = if prepared.effects.contains(Effect::LightGroups) {
        let means = u64::from(prepared.emitters.groups.count()) * size_of::<GroupMean>() as u64;
        let means = tiles * u64::from(TILE_PIXELS) * means;
        vec![
            ("direct.light_groups", means),
            ("direct.light_groups.staging", means),
        ]
    } else {
        Vec::new()
    };
    let all = SceneBuffers::sizes(prepared)
        .into_iter()
        .chain(of_image)
        .chain(groups);
    all.map(|(name, bytes)| Memory { name, bytes }).collect()
}

/// All together.
pub fn total(memory: &[Memory]) -> u64 {
    memory.iter().map(|m| m.bytes).sum()
}
