//! The types of a scene file's shapes and transforms. Their doc comments are descriptions in the
//! JSON Schema.

use super::format_textures::TextureTable;
use crate::scene::rgb::Rgb;
use schemars::JsonSchema;
use serde::Deserialize;
use strum::VariantNames;

/// A surface.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ShapeTable {
    /// Its geometry.
    #[schemars(flatten)]
    pub(super) kind: ShapeKind,
    /// A name for messages.
    pub(super) name: Option<String>,
    /// Name of its material; left out, those of an OBJ file's material libraries, else a grey
    /// Lambert material of reflectance 0.5.
    pub(super) material: Option<String>,
    /// What it emits, instead of what an OBJ file's material libraries say.
    pub(super) emission: Option<EmissionTable>,
    /// Steps that place it, the first listed is applied first.
    #[serde(default)]
    pub(super) transform: Vec<TransformStep>,
}

/// Geometry; the front is the side that the normal points to.
#[derive(Debug, Deserialize, JsonSchema, VariantNames)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[schemars(tag = "type")]
pub(super) enum ShapeKind {
    /// The square [-1, 1]² in the xy plane with normal +z; or `corner`, `u` and `v`.
    Rectangle(RectangleTable),
    /// The cube [-1, 1]³; or `min` and `max`. Its normals point outwards.
    Box(BoxTable),
    /// The unit sphere; or `center` and `radius`. Its normal points outwards. A transform that does
    /// not scale all axes alike makes it an ellipsoid.
    Sphere(SphereTable),
    /// The unit disk in the xy plane with normal +z; or `center`, `normal` and `radius`.
    Disk(DiskTable),
    /// Triangles from a file.
    Mesh(MeshTable),
}

/// The parallelogram corner + s·u + t·v with normal u × v. All three keys, or none.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RectangleTable {
    /// One corner.
    pub(super) corner: Option<[f64; 3]>,
    /// Edge from the corner.
    pub(super) u: Option<[f64; 3]>,
    /// Other edge from the corner.
    pub(super) v: Option<[f64; 3]>,
}

/// An axis-parallel box. Both keys, or none.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxTable {
    /// The corner with the smallest coordinates.
    pub(super) min: Option<[f64; 3]>,
    /// The corner with the largest coordinates.
    pub(super) max: Option<[f64; 3]>,
}

/// A sphere.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereTable {
    /// Centre; the origin when left out.
    #[serde(default)]
    pub(super) center: [f64; 3],
    /// Radius, above 0; 1 when left out.
    #[serde(default = "one")]
    pub(super) radius: f64,
}

/// A disk.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DiskTable {
    /// Centre; the origin when left out.
    #[serde(default)]
    pub(super) center: [f64; 3],
    /// Normal, of any length; +z when left out.
    #[serde(default = "z_axis")]
    pub(super) normal: [f64; 3],
    /// Radius, above 0; 1 when left out.
    #[serde(default = "one")]
    pub(super) radius: f64,
}

pub(super) fn one() -> f64 {
    1.0
}

fn z_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// Triangles from a file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    /// A .ply, .obj, .gltf or .glb file; of glTF, the geometry of its default scene.
    pub(super) file: String,
    /// What its vertex colours are, factors on the reflectance; linear when left out.
    #[serde(default)]
    pub(super) vertex_colors: VertexColors,
}

/// The meaning of a file's vertex colours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum VertexColors {
    /// Linear factors: 8 bits stand for n/255.
    #[default]
    Linear,
    /// Encoded as sRGB.
    Srgb,
    /// Nothing: they are left out.
    Ignore,
}

/// What a surface emits, the same in all directions.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EmissionTable {
    /// Radiance, not negative.
    pub(super) radiance: Rgb,
    /// Factor on it that varies over the surface; 8 and 16 bits are sRGB, floats linear.
    pub(super) texture: Option<TextureTable>,
    /// Whether the back emits as well.
    #[serde(default)]
    pub(super) two_sided: bool,
    /// Group in which its light is kept apart by the AOV `light-groups`; `default` when left out.
    pub(super) group: Option<String>,
}

/// A factor for all axes, or one for each.
#[derive(Debug, Clone, Copy, JsonSchema)]
#[schemars(untagged)]
#[expect(
    dead_code,
    reason = "the variants describe the two spellings to the schema"
)]
enum ScaleSpelling {
    Uniform(f64),
    PerAxis([f64; 3]),
}

/// A scale.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema)]
#[schemars(transparent)]
pub(super) struct Scale(#[schemars(with = "ScaleSpelling")] pub(super) [f64; 3]);

/// One step of a transform.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TransformStep {
    /// Moves by a vector.
    Translate([f64; 3]),
    /// Scales about the origin.
    Scale(Scale),
    /// Rotates about an axis through the origin.
    Rotate(RotateTable),
    /// Any affine matrix, row by row; the last row is [0, 0, 0, 1].
    Matrix([[f64; 4]; 4]),
    /// Puts the origin at `origin` and turns +z towards `target`.
    LookAt(LookAtTable),
}

/// A rotation.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotateTable {
    /// The axis, of any length.
    pub(super) axis: [f64; 3],
    /// The angle in degrees, counter-clockwise when the axis points at the viewer.
    pub(super) degrees: f64,
}

/// A placement by two points.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LookAtTable {
    /// Where the object's origin goes.
    pub(super) origin: [f64; 3],
    /// Where its +z axis points.
    pub(super) target: [f64; 3],
    /// Where its +y axis points as far as it can; [0, 1, 0] when left out.
    #[serde(default = "y_axis")]
    pub(super) up: [f64; 3],
}

fn y_axis() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
