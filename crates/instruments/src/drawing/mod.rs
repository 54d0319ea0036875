//! What the plots of the report, of the lab and of `explain` are drawn with.
//!
//! Drawings are SVG, written by hand: their colours are classes, so that they are light or dark, as
//! the reader's system is set. PNG files are drawn from the same SVG with a font that is compiled
//! in: a machine without any fonts gets the same pictures.

pub mod bars;
pub mod frame;
pub mod raster;
pub mod scale;
pub mod svg;
pub mod text;
