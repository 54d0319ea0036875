//! The binary container, GLB.

use super::document::slice;
use crate::error::InputError;
use std::path::Path;

/// Kind of the chunk that holds the JSON, `JSON` in ASCII.
const JSON: u64 = 0x4E4F_534A;
/// Kind of the chunk that holds buffer 0, `BIN` and a zero.
const BIN: u64 = 0x004E_4942;
/// Bytes of a chunk's header.
const HEADER: u64 = 8;

/// A file's JSON, and buffer 0 where it holds that, too: of a GLB by its first bytes, whatever the
/// file's name.
pub(super) fn split<'a>(
    path: &Path,
    bytes: &'a [u8],
) -> Result<(&'a [u8], Option<&'a [u8]>), InputError> {
    if bytes.starts_with(b"glTF") {
        split_glb(path, bytes)
    } else {
        Ok((bytes, None))
    }
}

/// The JSON chunk and the binary chunk; chunks of other kinds are passed over, as glTF 2.0 has it
/// (section 4.4.3).
fn split_glb<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), InputError> {
    let truncated = |needed: u64| {
        InputError::file(
            path,
            format!(
                "is truncated: it has {} bytes and needs {needed}",
                bytes.len()
            ),
            "the whole GLB file",
        )
    };
    let required = |at: u64| word(bytes, at).ok_or_else(|| truncated(at + 4));
    let version = required(4)?;
    if version != 2 {
        return Err(InputError::file(
            path,
            format!("is a GLB of version {version}"),
            "version 2",
        ));
    }
    let length = required(8)?;
    if length > bytes.len() as u64 {
        return Err(truncated(length));
    }
    let chunk = |at: u64| -> Result<(u64, &'a [u8], u64), InputError> {
        let size = required(at)?;
        let kind = required(at + 4)?;
        let end = at + HEADER + size;
        let data = slice(bytes, at + HEADER, size).ok_or_else(|| truncated(end))?;
        Ok((kind, data, following(bytes, end)))
    };
    let (kind, text, mut next) = chunk(12)?;
    if kind != JSON {
        return Err(InputError::file(
            path,
            "its first chunk is not JSON",
            "a GLB file",
        ));
    }
    while next + HEADER <= length {
        let (kind, data, end) = chunk(next)?;
        if kind == BIN {
            return Ok((text, Some(data)));
        }
        next = end;
    }
    Ok((text, None))
}

/// Where the chunk after one that ends at `end` begins: chunks begin at multiples of 4, but where a
/// writer pads none, its next one follows at once.
fn following(bytes: &[u8], end: u64) -> u64 {
    let aligned = end.next_multiple_of(4);
    let at_once = matches!(word(bytes, end + 4), Some(JSON | BIN));
    if at_once { end } else { aligned }
}

/// The 32-bit number at byte `at`.
fn word(bytes: &[u8], at: u64) -> Option<u64> {
    let word = slice(bytes, at, 4)?;
    let word = u32::from_le_bytes(word.try_into().expect("a slice of 4 bytes"));
    Some(word.into())
}
