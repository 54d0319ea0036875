//! Images against exact values, strategies against each other, and what must not change an image.

mod adaptive;
mod aov;
mod compensation;
mod error;
mod errors_of_random_scenes;
mod invariance;
mod ledger;
mod lens;
mod light_groups;
mod light_tree;
mod lights_in_view;
mod near_misses;
mod one_pixel;
mod opacity;
mod pixel_filter;
mod random_polygons;
mod scouts;
pub mod second_uvs;
mod shadow_rays;
mod strategies;
mod tangents;
mod test_scenes;
mod twin;
mod variance;
