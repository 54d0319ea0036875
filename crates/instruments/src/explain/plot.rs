//! The prices as a drawing.

use super::price::Prices;
use crate::drawing::bars::{Bar, draw};
use crate::drawing::svg::Svg;

/// Time per sample and compile time of every kernel, over those of what the scene calls for.
pub fn of(scene: &str, prices: &Prices) -> Svg {
    let bars = prices.kernels.iter().skip(1).flat_map(|price| {
        let bar = |what: &str, series: usize, value| Bar {
            name: format!("{}: {what}", price.kernel),
            series,
            value,
        };
        [
            bar("time per sample", 0, price.sample_ratio),
            bar("compile time", 1, price.compile_ratio),
        ]
    });
    let title = format!("What effects cost that {scene} does not call for");
    let bars: Vec<Bar> = bars.collect();
    draw(&title, "times that of what is called for", &bars)
}
