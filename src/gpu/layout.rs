//! Structs shared with the shaders. `tests/layout.rs` compares every member with
//! `shaders/types.wesl`.

use crate::accel::{MAX_LIGHT_BOXES, attributes};
use crate::prepare::lights_in_view::MAX_LIGHTS_IN_VIEW;
use crate::prepare::small_lights::MAX_SMALL_LIGHTS;
use crate::scene::Light;
use bytemuck::{Pod, Zeroable};

/// `CameraUniform` of `shaders/types.wesl`. The camera. Space: the normalised scene (see
/// `scene::normalize`).
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CameraUniform {
    /// Centre of projection; of a distant camera, a point on its near plane.
    pub eye: [f32; 3],
    /// Distance from the eye of the plane on which the rays of a distant camera begin, along the
    /// viewing direction; else 0.
    pub near_plane: f32,
    /// Half the image plane's width at distance 1, to the right.
    pub right: [f32; 3],
    /// Size of the lens's image on the near plane: 1 where there is none.
    pub near_lens: f32,
    /// Half the image plane's height at distance 1, upwards.
    pub up: [f32; 3],
    /// One over the distance of the plane that is sharp.
    pub inverse_focus_distance: f32,
    /// Unit viewing direction.
    pub forward: [f32; 3],
    /// 1 where the camera is orthographic: `right` and `up` are then half the size of what is seen.
    pub orthographic: u32,
    /// Radius of the lens, to the right.
    pub lens_right: [f32; 3],
    /// Most specular surfaces that a camera ray goes on from.
    pub max_specular_depth: u32,
    /// Radius of the lens, upwards.
    pub lens_up: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// `FilmUniform` of `shaders/types.wesl`. The image and its reconstruction filter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FilmUniform {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 8 × 8 tiles per row of tiles.
    pub tiles_per_row: u32,
    /// Width of a cell of the pixel filter's table, in pixels.
    pub filter_cell: f32,
    /// The pixel filter's table, two ends of cells per word: see `shaders/kernel/filter.wesl`.
    pub filter_knots: [[f32; 4]; FILTER_WORDS],
}

/// `BvhUniform` of `shaders/types.wesl`. The hierarchy and the grid on which its boxes lie.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BvhUniform {
    /// Lower corner of the grid.
    pub grid_origin: [f32; 3],
    /// Reference to the root.
    pub root: u32,
    /// Grid cells per unit length.
    pub grid_scale: [f32; 3],
    /// 1 where the grid is logarithmic.
    pub logarithmic_grid: u32,
    /// Where the kernel is specialized for a few large primitives, the box around the others on the
    /// grid.
    pub small_box: [u32; 3],
    /// Unused.
    pub padding: u32,
}

/// `EnvironmentUniform` of `shaders/types.wesl`. The environment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct EnvironmentUniform {
    /// First row of the rotation from world space to the map's space.
    pub x: [f32; 3],
    /// Texels per row of the map; 0 where there is none.
    pub width: u32,
    /// Second row.
    pub y: [f32; 3],
    /// Rows of the map.
    pub height: u32,
    /// Third row.
    pub z: [f32; 3],
    /// Expected samples per shadow ray; see `LightRecord` of `shaders/scene/fetch.wesl`.
    pub samples_per_ray: f32,
    /// Constant radiance, or the factor on the map's.
    pub radiance: [f32; 3],
    /// 1 where the map is interpolated between its texels.
    pub linear: u32,
    /// Texels of the sampling grid per row and column: the map's, or blocks of its texels.
    pub grid: [u32; 2],
    /// Unused.
    pub padding: [u32; 2],
}

/// `LightTreeUniform` of `shaders/types.wesl`. The light tree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightTreeUniform {
    /// Lower corner of the grid on which its spheres lie.
    pub grid_origin: [f32; 3],
    /// Number of nodes.
    pub nodes: u32,
    /// Size of the grid's cells.
    pub grid_step: [f32; 3],
    /// Sampled lights that the tree leaves out.
    pub infinite_lights: u32,
}

/// `LightsUniform` of `shaders/types.wesl`. The lights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightsUniform {
    /// Number of lights.
    pub count: u32,
    /// Index of the first sun.
    pub first_sun: u32,
    /// Number of suns.
    pub suns: u32,
    /// Word of the lights at which the maps of emission begin.
    pub first_emission: u32,
    /// Boxes around the primitives that emit, as in a node of the BVH; the fourth word is unused.
    pub boxes: [[u32; 4]; MAX_LIGHT_BOXES],
}

/// `PatternsUniform` of `shaders/types.wesl`. The sampler's patterns: logarithms of the jittered
/// grid's columns and rows, or of the samples per pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PatternsUniform {
    /// For the samples of a pixel.
    pub pixel: [u32; 2],
    /// For the light samples of a pixel, where a sample of it has several.
    pub light: [u32; 2],
}

/// `ShadowUniform` of `shaders/types.wesl`. Shadow rays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowUniform {
    /// Per camera ray; with light selection `all` per light.
    pub rays: u32,
    /// Columns of the grid that their points lie on.
    pub columns: u32,
    /// Lattice step from one shadow ray to the next, in units of 2⁻³²: for the choice of the light
    /// and of the environment's texel.
    pub steps: [u32; 2],
}

/// `LightInViewUniform` of `shaders/types.wesl`: a light that is sampled in view
/// of the camera.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightInViewUniform {
    /// Least and largest x and y, in pixels, of the middles of the pixels that may show it: min x,
    /// min y, max x, max y.
    pub bounds: [f32; 4],
    /// The light.
    pub light: u32,
    /// Where its points are chosen: 0 on the light, to be seen from the lens, 1 on the light, to be seen
    /// through the point in focus, 2 in the pixel.
    pub points: u32,
    /// How many points a sample has.
    pub per_sample: u32,
    /// Unused.
    pub padding: u32,
}

/// `SmallLightUniform` of `shaders/types.wesl`: a small light that camera rays meet by chance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SmallLightUniform {
    /// Its middle; of a distant one the unit direction to it.
    pub place: [f32; 3],
    /// Radius of a sphere around it; of a point the cosine at the axis beyond which it does not shine.
    pub radius: f32,
    /// Normal times area of a planar one; (mean area across the line of sight, –, –) of a body;
    /// (solid angle, –, –) of a distant one; axis of a point.
    pub area: [f32; 3],
    /// 0 a body, 1 planar, 2 planar and both sides shine, 3 distant, 4 a point.
    pub kind: u32,
    /// Radiance; irradiance from a distant one, radiant intensity of a point. Of one that stands for
    /// several as much more.
    pub strength: [f32; 3],
    /// 1 where the camera may see it and it is not sampled there.
    pub is_in_view: u32,
}

/// `Frame` of `shaders/types.wesl`: what stays the same for a whole render.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// The camera. Space: the normalised scene (see `scene::normalize`).
    pub camera: CameraUniform,
    /// The image and its reconstruction filter.
    pub film: FilmUniform,
    /// The hierarchy and the grid on which its boxes lie.
    pub bvh: BvhUniform,
    /// The environment.
    pub environment: EnvironmentUniform,
    /// The light tree.
    pub light_tree: LightTreeUniform,
    /// The lights.
    pub lights: LightsUniform,
    /// The sampler's patterns: logarithms of the jittered grid's columns and rows, or of the
    /// samples per pixel.
    pub patterns: PatternsUniform,
    /// Shadow rays.
    pub shadow: ShadowUniform,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Length beyond everything in the scene, for shadow rays to infinitely distant lights.
    pub far: f32,
    /// Number of the lights that are sampled in view.
    pub lights_in_view_count: u32,
    /// Number of the small lights that camera rays meet by chance.
    pub small_lights_count: u32,
    /// These lights.
    pub lights_in_view: [LightInViewUniform; MAX_LIGHTS_IN_VIEW],
    /// The small lights that camera rays meet by chance.
    pub small_lights: [SmallLightUniform; MAX_SMALL_LIGHTS],
}

/// Words of [`FilmUniform::filter_knots`].
pub const FILTER_WORDS: usize = (FILTER_CELLS as usize + 1).div_ceil(2);

/// `Dispatch` of `shaders/types.wesl`: what changes from dispatch to dispatch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Dispatch {
    /// Index of the first sample of the block, low and high word.
    pub block_start: [u32; 2],
    /// First tile of this dispatch, counted over the image.
    pub first_tile: u32,
    /// Where the tasks of this dispatch begin in the bound region's schedule, in words; for kernels
    /// whose workgroups have tasks.
    pub first_task: u32,
    /// Position in the block up to which every pixel is taken, where workgroups have no tasks.
    pub target_position: u32,
    /// Unused.
    pub padding: u32,
}

/// `RowTask` of `shaders/types.wesl`: what a workgroup does, which is to take a row of pixels from
/// where their states stand to a position in their block.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct RowTask {
    /// Index of the first sample of the block, low and high word.
    pub block_start: [u32; 2],
    /// The row, in the order of the bound region's pixels.
    pub row: u32,
    /// Position in the block up to which every pixel is taken.
    pub target_position: u32,
}

/// `PixelState` of `shaders/types.wesl`: one pixel's block of at most [`BLOCK_SAMPLES`] samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelState {
    /// Mean radiance of the finite samples.
    pub mean: [f32; 3],
    /// Number of finite samples.
    pub samples: u32,
    /// Sum of squared deviations from the mean.
    pub m2: [f32; 3],
    /// Number of samples dropped because they were not finite.
    pub dropped: u32,
    /// Shadow rays traced.
    pub shadow_rays: u32,
    /// Rays traced in BSDF-sampled directions.
    pub bsdf_rays: u32,
    /// Position in the block of the first NaN sample, or 0xffff, and above these 16 bits that of the
    /// first infinite sample.
    pub first_bad: u32,
    /// How often they should have met light of small lights.
    pub expected_hits: f32,
    /// Mean radiance of the finite samples at odd positions: the second replicate.
    pub second_mean: [f32; 3],
    /// Number of finite samples at odd positions.
    pub second_samples: u32,
    /// Sum of squared deviations of the second replicate from its mean.
    pub second_m2: [f32; 3],
    /// Sum over all samples of the squared radiance of light that they should have met, as near misses
    /// of small lights tell; see `shaders/kernel/near_misses.wesl`.
    pub expected_squares: f32,
}

impl PixelState {
    /// Positions in the block of the first NaN and of the first infinite sample.
    pub fn first_bad(&self) -> [Option<u32>; 2] {
        [self.first_bad & 0xffff, self.first_bad >> 16].map(|p| (p != 0xffff).then_some(p))
    }
}

/// A pixel's mean radiance of a group of lights, as bits, and the number of its samples; see
/// `shaders/kernel/light_groups.wesl`.
pub type GroupMean = [u32; 4];

/// `SampleRecord` of `shaders/types.wesl`: what one sample found and what its rays met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SampleRecord {
    /// Radiance of the sample.
    pub radiance: [f32; 3],
    /// Its shadow rays: multiples of `SHADOW_…`.
    pub shadow: u32,
    /// The part of the radiance that light sampling found.
    pub by_light: [f32; 3],
    /// Primitive that the camera ray met, or [`NONE`]; where it went on, a hash of all that it met.
    pub camera_primitive: u32,
    /// The part that BSDF sampling found.
    pub by_bsdf: [f32; 3],
    /// Primitive that the BSDF-sampled ray met, [`NONE`], or [`NOT_TRACED`].
    pub bsdf_primitive: u32,
}

impl SampleRecord {
    /// Shadow rays traced.
    pub fn shadow_rays(&self) -> u32 {
        self.shadow % SHADOW_CLEAR
    }

    /// Those that met nothing.
    pub fn clear_shadow_rays(&self) -> u32 {
        self.shadow / SHADOW_CLEAR
    }
}

/// `FeatureSums` of `shaders/types.wesl`: sums over samples of what a denoiser asks for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FeatureSums {
    /// Albedo where camera paths end.
    pub albedo: [f32; 3],
    /// Number of samples.
    pub samples: u32,
    /// Unit shading normal there.
    pub normal: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// `SurfaceRecord` of `shaders/types.wesl`: the surface in the middle of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceRecord {
    /// Point on the primitive, normalised space.
    pub position: [f32; 3],
    /// The primitive, or [`NONE`].
    pub primitive: u32,
    /// Unit geometric normal, on the viewer's side.
    pub normal: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// Most samples that are accumulated in f32 before the host merges them in f64.
pub const BLOCK_SAMPLES: u32 = 256;
/// Pixels per side of a tile; a tile is a workgroup.
pub const TILE: u32 = 8;
/// Pixels per tile.
pub const TILE_PIXELS: u32 = TILE * TILE;

/// Position in its tile of the pixel that lane `lane` works on: Morton order.
pub fn lane_pixel(lane: u32) -> (u32, u32) {
    let x = (lane & 1) | ((lane >> 1) & 2) | ((lane >> 2) & 4);
    let y = ((lane >> 1) & 1) | ((lane >> 2) & 2) | ((lane >> 3) & 4);
    (x, y)
}

/// A constant that a shader module and the host share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedConstant {
    /// The shader module, as in `import package::scene::fetch::…`.
    pub module: &'static str,
    /// Its name there.
    pub name: &'static str,
    /// Its value here.
    pub value: u32,
}

macro_rules! shared {
    ($($(#[$doc:meta])* $module:literal $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        const SHARED_CONSTANTS: &[SharedConstant] = &[
            $(SharedConstant { module: $module, name: stringify!($name), value: $name },)*
        ];
    };
}

/// Everything that `tests/layout.rs` compares with the shaders: the constants below, and those of
/// the kinds of lights.
pub fn shared_constants() -> Vec<SharedConstant> {
    let of_lights = Light::CONSTANTS.iter();
    let of_lights = of_lights.map(|&(module, name, value)| SharedConstant {
        module,
        name,
        value,
    });
    SHARED_CONSTANTS.iter().copied().chain(of_lights).collect()
}

shared! {
    /// No index.
    "core::constants" NONE = u32::MAX;
    /// Marks a reference to a leaf of the BVH.
    "core::bvh" LEAF = crate::accel::flatten::LEAF;
    /// A triangle.
    "scene::fetch" KIND_TRIANGLE = 0;
    /// A rectangle.
    "scene::fetch" KIND_RECTANGLE = 1;
    /// A disk.
    "scene::fetch" KIND_DISK = 2;
    /// A sphere.
    "scene::fetch" KIND_SPHERE = 3;
    /// An ellipsoid.
    "scene::fetch" KIND_ELLIPSOID = 4;
    /// Set in a primitive's head where its back does not exist.
    "scene::fetch" ONE_SIDED_BIT = 8;
    /// Bits below the material in a primitive's head.
    "scene::fetch" MATERIAL_SHIFT = 4;
    /// Words of a material.
    "scene::fetch" MATERIAL_WORDS = 5;
    /// Schlick's Fresnel term.
    "scene::fetch" FRESNEL_SCHLICK = 0;
    /// The same reflectance at every angle.
    "scene::fetch" FRESNEL_CONSTANT = 1;
    /// Fresnel's equations for a dielectric.
    "scene::fetch" FRESNEL_DIELECTRIC = 2;
    /// Fresnel's equations for a conductor.
    "scene::fetch" FRESNEL_CONDUCTOR = 3;
    /// Set in a material's bits where light passes straight through.
    "scene::fetch" THIN_BIT = 4;
    /// Set in a material's bits where light that meets several of its facets counts.
    "scene::fetch" COMPENSATED_BIT = 8;
    /// Set in a material's bits where its diffuse colour is what it shows.
    "scene::fetch" UNLIT_BIT = 16;
    /// Set where a primitive has vertex normals.
    "scene::fetch" HAS_NORMALS = 1;
    /// Set where a primitive has texture coordinates that its material reads.
    "scene::fetch" HAS_UVS = 2;
    /// Set where a primitive has an opacity.
    "scene::fetch" HAS_OPACITY = 4;
    /// Set where a primitive has vertex colours.
    "scene::fetch" HAS_COLORS = 8;
    /// Set where a primitive has tangents.
    "scene::fetch" HAS_TANGENTS = 16;
    /// Bits below the first word of a primitive's attributes.
    "scene::fetch" ATTRIBUTE_BITS = 5;
    /// Words of a triangle's normals and texture coordinates.
    "scene::attributes" NORMAL_AND_UV_WORDS = attributes::NORMAL_AND_UV_WORDS as u32;
    /// Words of a triangle's colours.
    "scene::attributes" COLOR_WORDS = attributes::COLOR_WORDS as u32;
    /// Words of a triangle's tangents.
    "scene::attributes" TANGENT_WORDS = attributes::TANGENT_WORDS as u32;
    /// Words of a textured material.
    "scene::textured" TEXTURED_WORDS = 4;
    /// An image again outside of itself.
    "scene::texture" WRAP_REPEAT = 0;
    /// Mirrored.
    "scene::texture" WRAP_MIRROR = 1;
    /// Continued by its edge.
    "scene::texture" WRAP_CLAMP = 2;
    /// Set beside the wrapping modes where an image is constant in each texel.
    "scene::texture" NEAREST_BIT = 16;
    /// Set beside the wrapping modes where an image is read with the second texture coordinates.
    "scene::texture" SECOND_UVS_BIT = 32;
    /// A triangle that emits.
    "scene::fetch" LIGHT_TRIANGLE = 0;
    /// A rectangle that emits.
    "scene::fetch" LIGHT_RECTANGLE = 1;
    /// A disk that emits.
    "scene::fetch" LIGHT_DISK = 2;
    /// A sphere that emits.
    "scene::fetch" LIGHT_SPHERE = 3;
    /// The environment.
    "scene::fetch" LIGHT_ENVIRONMENT = 7;
    /// The bits of a light's head that hold its kind.
    "scene::fetch" LIGHT_KIND_MASK = 15;
    /// Set in a light's head where its back emits as well.
    "scene::fetch" TWO_SIDED_BIT = 16;
    /// Set in a light's head where its edges or half axes are not orthogonal, and where a sphere is
    /// an ellipsoid.
    "scene::fetch" SKEWED_BIT = 32;
    /// Words of a light.
    "scene::fetch" LIGHT_WORDS = 4;
    /// From this bit of a light's head on stands the number of its emission map, from 1.
    "scene::fetch" EMISSION_SHIFT = 6;
    /// Largest number of an emission map.
    "scene::fetch" EMISSION_MASK = 0x3ffff;
    /// Words of an emission map.
    "scene::fetch" EMISSION_WORDS = 3;
    /// Where the group stands in a light's head.
    "kernel::light_groups" LIGHT_GROUP_SHIFT = 24;
    /// Points of a light in view are chosen on it, to be seen from the lens.
    "kernel::lights_in_view" POINTS_OF_FILM = 0;
    /// They are chosen on it, to be seen through the point in focus.
    "kernel::lights_in_view" POINTS_OF_LENS = 1;
    /// They are chosen in the pixel.
    "kernel::lights_in_view" POINTS_OF_PIXEL = 2;
    /// How many points a sample has at most.
    "kernel::lights_in_view" MOST_POINTS = crate::prepare::lights_in_view::MOST_POINTS;
    /// A small light shines in all directions alike.
    "kernel::near_misses" SMALL_BODY = 0;
    /// It is planar.
    "kernel::near_misses" SMALL_PLANAR = 1;
    /// It is planar, and both sides shine.
    "kernel::near_misses" SMALL_TWO_SIDED = 2;
    /// It is infinitely far away.
    "kernel::near_misses" SMALL_DISTANT = 3;
    /// It has no extent.
    "kernel::near_misses" SMALL_POINT = 4;
    /// Marks a reference to a light in the light tree.
    "light::tree" TREE_LEAF = crate::emitters::tree::TREE_LEAF;
    /// Cells of the pixel filter's table.
    "kernel::filter" FILTER_CELLS = crate::scene::filter::FILTER_CELLS as u32;
    /// What a traced shadow ray adds to `SampleRecord::shadow`.
    "kernel::sample_record" SHADOW_TRACED = 1;
    /// What one that met nothing adds to it as well.
    "kernel::sample_record" SHADOW_CLEAR = 1 << 16;
    /// The BSDF-sampled ray was not traced.
    "kernel::sample_record" NOT_TRACED = 0xffff_fffe;
}
