//! Images that were written.

use exr::prelude::read_first_flat_layer_from_file;
use std::path::Path;

/// Radiance of an EXR: its size, and red, green and blue row by row.
pub fn radiance(path: &Path) -> ([usize; 2], Vec<[f32; 3]>) {
    let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
    let channels = ["R", "G", "B"].map(|name| {
        let mut channels = layer.channel_data.list.iter();
        let channel = channels.find(|c| c.name.to_string() == name).unwrap();
        channel.sample_data.values_as_f32().collect::<Vec<_>>()
    });
    let pixels = 0..channels[0].len();
    let size = [layer.size.0, layer.size.1];
    (
        size,
        pixels.map(|i| channels.each_ref().map(|c| c[i])).collect(),
    )
}
