//! Acceleration: the scene's primitives and a bounding volume hierarchy over them.
//!
//! [`mod@primitives`] flattens shapes into triangles, rectangles, disks, spheres and ellipsoids in
//! normalised space; [`mod@build`] makes a binary BVH (by `obvhs`); [`flatten`] turns it into the
//! nodes that the GPU reads; [`mod@light_boxes`] tells which rays can meet a light.

pub mod attributes;
pub mod build;
pub mod flatten;
pub mod grid;
pub mod light_boxes;
pub mod octahedral;
pub mod parts;
pub mod primitives;

pub use attributes::{Attributed, Attributes, texture_coordinates};
pub use build::{build, build_extreme};
pub use flatten::{Bvh, Node};
pub use grid::Grid;
pub use light_boxes::{MAX_LIGHT_BOXES, light_boxes};
pub use primitives::{Primitive, PrimitiveGeometry, primitives};
