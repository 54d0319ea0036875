//! Environment maps: Radiance HDR and OpenEXR.

use super::decode::{Wanted, decode};
use super::files;
use crate::error::InputError;
use crate::scene::EnvironmentMap;
use crate::scene::environment::Interpolation;
use std::path::Path;

/// Longest side of a map.
const MAX_SIDE: u32 = 32_768;

/// Reads a latitude-longitude map, of an OpenEXR file the layer called `layer`. Texels that are
/// negative or not finite become black; `warnings` gets their number.
pub(super) fn read_environment(
    path: &Path,
    layer: Option<&str>,
    warnings: &mut Vec<String>,
) -> Result<EnvironmentMap, InputError> {
    let wanted = Wanted {
        file: path,
        is_color: true,
        layer,
        max_side: MAX_SIDE,
        is_radiance: true,
    };
    let image = decode(&wanted, &files::read(path)?, warnings)?;
    let (width, height) = (image.width(), image.height());
    let image = image.into_rgb32f();
    let mut texels: Vec<[f32; 3]> = image.pixels().map(|p| p.0).collect();
    let mut bad = 0usize;
    for texel in &mut texels {
        if texel.iter().any(|c| !c.is_finite() || *c < 0.0) {
            bad += 1;
            *texel = texel.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
        }
    }
    if bad > 0 {
        warnings.push(format!(
            "{}: {bad} {} negative or not finite; such channels are taken as 0",
            path.display(),
            if bad == 1 { "texel is" } else { "texels are" }
        ));
    }
    Ok(EnvironmentMap {
        source: path.display().to_string(),
        width,
        height,
        texels,
        interpolation: Interpolation::default(),
    })
}
