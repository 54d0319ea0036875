//! The types of a scene file. Their doc comments are the descriptions in the JSON Schema.

use crate::scene::environment::Interpolation;
use crate::scene::filter::FilterKind;
use crate::scene::lights::LightKeys;
use crate::scene::rgb::Rgb;
use crate::scene::settings::RenderTable;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

use super::format_materials::MaterialTable;
use super::format_shapes::{ShapeTable, TransformStep, one};

/// A direkt scene: camera, film, materials, shapes, lights, environment and settings.
///
/// Lengths are in any one unit; angles are in degrees; colours are linear RGB. Files are named
/// relative to the scene file's folder, or to a folder named with `--assets`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "direkt scene")]
pub(super) struct SceneFile {
    /// The camera. Left out: that of the first included glTF with a camera, or else one that frames
    /// the geometry.
    pub(super) camera: Option<CameraTable>,
    /// Size of the image.
    #[serde(default)]
    pub(super) film: FilmTable,
    /// Materials by name.
    #[serde(default)]
    pub(super) materials: BTreeMap<String, MaterialTable>,
    /// Surfaces.
    #[serde(default)]
    pub(super) shapes: Vec<ShapeTable>,
    /// glTF files that are included with their shapes, materials, lights and camera.
    #[serde(default)]
    pub(super) gltf: Vec<GltfTable>,
    /// Lights without a surface.
    #[serde(default)]
    pub(super) lights: Vec<LightTable>,
    /// Light from everywhere that no surface covers.
    pub(super) environment: Option<EnvironmentTable>,
    /// How to render; every setting also has a flag.
    #[serde(default)]
    pub(super) render: RenderTable,
    /// What the image must be, for `direkt render --check`.
    pub(super) expect: Option<ExpectTable>,
}

/// A camera: `eye` and `target`, or `matrix`; with a `lens_radius`, a thin lens.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    /// How points of the scene come to lie on the image.
    #[serde(rename = "type", default)]
    pub(super) kind: CameraKind,
    /// Centre of projection, or the middle of the plane that parallel rays start on.
    pub(super) eye: Option<[f64; 3]>,
    /// A point in the middle of the image.
    pub(super) target: Option<[f64; 3]>,
    /// What is up in the image; [0, 1, 0] when left out.
    pub(super) up: Option<[f64; 3]>,
    /// Camera to world, row by row; the camera looks along its −z with +y up, as in glTF.
    pub(super) matrix: Option<[[f64; 4]; 4]>,
    /// Of a perspective camera: vertical field of view in degrees, above 0 and below 180.
    pub(super) fov: Option<f64>,
    /// Of an orthographic camera: height of what is seen, above 0.
    pub(super) height: Option<f64>,
    /// Radius of the lens, not negative; 0, a pinhole, when left out.
    #[serde(default)]
    pub(super) lens_radius: f64,
    /// Distance from the eye, along the viewing direction, of the plane that is sharp, above 0;
    /// that of `target` when left out.
    pub(super) focus_distance: Option<f64>,
}

/// How points of the scene come to lie on the image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum CameraKind {
    /// Through the eye, by `fov`.
    #[default]
    Perspective,
    /// By parallel rays, by `height`.
    Orthographic,
}

/// Size of the image in pixels, and what each pixel shows.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FilmTable {
    /// Pixels per row, 1 to 32768.
    #[schemars(range(min = 1, max = 32768))]
    pub(super) width: i64,
    /// Rows, 1 to 32768.
    #[schemars(range(min = 1, max = 32768))]
    pub(super) height: i64,
    /// What a pixel shows of what lies around its middle: a function of the distance along each
    /// axis.
    pub(super) filter: FilterKind,
    /// Distance from the pixel's middle from which on the filter is zero, in pixels, above 0. When
    /// left out: 0.5 for `box`, 1 for `tent`, 1.5 for `gaussian`, 2 for `blackman-harris`.
    pub(super) filter_radius: Option<f64>,
    /// Of the filter `gaussian`: its standard deviation in pixels, above 0; 0.5 when left out.
    pub(super) filter_stddev: Option<f64>,
}

impl Default for FilmTable {
    fn default() -> Self {
        let film = crate::scene::FilmSize::default();
        Self {
            width: film.width.into(),
            height: film.height.into(),
            filter: FilterKind::default(),
            filter_radius: None,
            filter_stddev: None,
        }
    }
}

/// A glTF file to include.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GltfTable {
    /// A .gltf or .glb file.
    pub(super) file: String,
    /// Steps that place it, the first listed is applied first. Radiance and intensities stay as
    /// they are.
    #[serde(default)]
    pub(super) transform: Vec<TransformStep>,
    /// Group of all its lights and surfaces that emit; `default` when left out.
    pub(super) group: Option<String>,
}

/// A light without a surface.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    /// Its kind.
    #[schemars(flatten)]
    pub(super) kind: LightKeys,
    /// Group in which its light is kept apart by the AOV `light-groups`; `default` when left out.
    pub(super) group: Option<String>,
}

/// Light from everywhere: `radiance` or `file`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    /// The same radiance from everywhere.
    pub(super) radiance: Option<Rgb>,
    /// A latitude-longitude map (.hdr, .exr); +y is up, and its middle lies in direction −z.
    pub(super) file: Option<String>,
    /// The layer of an OpenEXR file, such as `ViewLayer.Combined`; the colours without a layer, or
    /// those of the only one, when left out.
    pub(super) layer: Option<String>,
    /// What lies between the map's texels.
    #[serde(default)]
    pub(super) interpolation: Interpolation,
    /// Rotation about +y in degrees, counter-clockwise seen from above.
    #[serde(default)]
    pub(super) rotation: f64,
    /// Factor on the radiance.
    #[serde(default = "one")]
    pub(super) scale: f64,
    /// Group in which its light is kept apart by the AOV `light-groups`; `default` when left out.
    pub(super) group: Option<String>,
}

/// The exact image: `radiance` or `pixels`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExpectTable {
    /// Mean radiance of the image, not negative.
    pub(super) radiance: Option<Rgb>,
    /// Radiance of every pixel, row by row from the top, not negative.
    pub(super) pixels: Option<Vec<Vec<Rgb>>>,
    /// Where the value comes from: a formula, a paper, a book.
    pub(super) source: String,
    /// Relative allowance for the rounding of a published value, from 0 to below 1.
    #[serde(default)]
    pub(super) tolerance: f64,
}
