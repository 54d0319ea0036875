//! What the decoder of OpenEXR would believe, checked before it does: it makes room for all that a
//! file announces, and ends the process where there is none.

use super::refusal;
use crate::error::InputError;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::Compression;
use std::io::Cursor;
use std::path::Path;

/// Most bytes that a byte of a file becomes, texels outside of the image and channels that are not
/// read included: what zlib packs.
const MAX_EXPANSION: u64 = 1032;
/// Numbers at the beginning of a DWA chunk, 64 bits each.
const DWA_COUNTERS: usize = 11;
/// Which of them announce uncompressed data, with the bytes of what they count: data of channels
/// that are stored as they are; run-length encoded data, packed and unpacked; coefficients of the
/// cosine transform, AC and DC.
const DWA_ANNOUNCED: [(usize, u64); 5] = [(1, 1), (6, 1), (7, 1), (8, 2), (9, 2)];

/// Refuses windows, channels and chunks that announce more than the file can hold.
pub(super) fn check(path: &Path, bytes: &[u8], meta: &MetaData) -> Result<(), InputError> {
    let failed = |e: exr::error::Error| refusal(path, &e);
    for header in &meta.headers {
        check_window(path, header, bytes.len())?;
    }
    let is_dwa = |h: &Header| matches!(h.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if !meta.headers.iter().any(is_dwa) {
        return Ok(());
    }
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(failed)?;
    let chunks = reader
        .filter_chunks(false, |_, _, _| true)
        .map_err(failed)?;
    for chunk in chunks {
        let chunk = chunk.map_err(failed)?;
        let header = meta.headers.get(chunk.layer_index);
        if let Some(header) = header.filter(|h| is_dwa(h)) {
            check_dwa(path, header, &chunk)?;
        }
    }
    Ok(())
}

fn check_window(path: &Path, header: &Header, length: usize) -> Result<(), InputError> {
    let size = header.layer_size;
    let texels = (size.width() as u64).saturating_mul(size.height() as u64);
    let texel = header.channels.bytes_per_pixel;
    if texels.saturating_mul(texel as u64) <= MAX_EXPANSION * length as u64 {
        return Ok(());
    }
    let (width, height) = (size.width(), size.height());
    Err(InputError::new(
        path,
        "dataWindow",
        format!("is {width} x {height} texels of {texel} bytes, but the file has {length} bytes"),
        "the whole image (is the file truncated?)",
    ))
}

/// Refuses a chunk that announces more than twice what its texels take, in whole blocks of 8 x 8.
fn check_dwa(path: &Path, header: &Header, chunk: &Chunk) -> Result<(), InputError> {
    let data = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let size = header
        .get_block_data_indices(&chunk.compressed_block)
        .and_then(|tile| header.get_absolute_block_pixel_coordinates(tile))
        .map_err(|e| refusal(path, &e))?
        .size;
    let texel = header.channels.bytes_per_pixel;
    // What would not get smaller is stored as it is.
    if data.len() == size.area().saturating_mul(texel) {
        return Ok(());
    }
    let side = |texels: usize| texels.next_multiple_of(8) as u64;
    let most = 2 * side(size.width()) * side(size.height()) * texel as u64;
    let counters: Vec<u64> = data
        .as_chunks::<8>()
        .0
        .iter()
        .take(DWA_COUNTERS)
        .map(|word| u64::from_le_bytes(*word))
        .collect();
    for (index, bytes) in DWA_ANNOUNCED {
        let announced = counters.get(index).copied().unwrap_or(0);
        if announced.saturating_mul(bytes) > most {
            return Err(InputError::file(
                path,
                format!("is damaged: a chunk of DWA announces {announced} values"),
                format!("at most {} for its texels", most / bytes),
            ));
        }
    }
    Ok(())
}
