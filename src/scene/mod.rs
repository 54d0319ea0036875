//! The scene, in f64, as the file describes it.
//!
//! [`load`] reads a TOML, glTF or GLB file into a [`Scene`] and validates it; [`normalize`] moves
//! and scales it for f32. Nothing here knows of the GPU.

pub mod alias_table;
pub mod aov;
pub mod camera;
mod choice;
pub mod ellipsoid;
pub mod enlarge;
pub mod environment;
pub mod error_metric;
pub mod expect;
pub mod filter;
pub mod fresnel;
pub mod ids;
pub mod light_groups;
pub mod lights;
pub mod load;
pub mod lookup;
pub mod material;
pub mod metals;
pub mod normalize;
pub mod opacity;
mod range;
pub mod refine;
mod rgb;
pub mod sampler;
pub mod settings;
pub mod shadow_rays;
pub mod shape;
pub mod texture;
pub mod validate;
mod view;

pub use aov::{Aov, Aovs};
pub use camera::{Camera, FilmSize, Lens, Projection};
pub use environment::{Environment, EnvironmentMap, EnvironmentRadiance};
pub use error_metric::ErrorMetric;
pub use expect::{Expect, ExpectedRadiance};
pub use filter::PixelFilter;
pub use ids::{MaterialId, ShapeId, TextureId};
pub use light_groups::LightGroups;
pub use lights::{DirectionalLight, Light, PointLight, SpotLight, SunLight};
pub use material::{Bsdf, Material};
pub use opacity::Opacity;
pub use rgb::Rgb;
pub use sampler::Sampler;
#[cfg(feature = "clap")]
pub use settings::EstimatorFlags;
pub use settings::{
    EstimatorSettings, LightSampling, LightSelection, RenderSettings, StopSettings, Strategy,
};
pub use shadow_rays::{ShadowGrid, ShadowPattern, ShadowRays};
pub use shape::{Emission, Geometry, Mesh, Shape};
pub use texture::{MaterialTextures, NormalMap, Texels, Texture, TextureUse, Wrap};

/// Everything that is rendered, in world space and f64.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The file it was read from, as the user named it.
    pub source: std::path::PathBuf,
    /// The camera.
    pub camera: Camera,
    /// Size of the image.
    pub film: FilmSize,
    /// Surfaces' materials.
    pub materials: Vec<Material>,
    /// Images that materials read.
    pub textures: Vec<Texture>,
    /// Surfaces.
    pub shapes: Vec<Shape>,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// Light from everywhere else.
    pub environment: Option<Environment>,
    /// How to render, unless a flag says otherwise.
    pub render: RenderSettings,
    /// What the image must be, where that is known.
    pub expect: Option<Expect>,
    /// What the file asks for and direkt does not do, or what was dropped: one sentence each.
    pub warnings: Vec<String>,
    /// The pixel reconstruction filter.
    pub filter: PixelFilter,
    /// Which light belongs to which group.
    pub light_groups: LightGroups,
}

impl Default for Scene {
    /// Nothing, in front of a camera at (0, 0, 4) that looks at the origin.
    fn default() -> Self {
        Self {
            source: std::path::PathBuf::from("scene"),
            camera: Camera::default(),
            film: FilmSize::default(),
            materials: Vec::new(),
            textures: Vec::new(),
            shapes: Vec::new(),
            lights: Vec::new(),
            environment: None,
            render: RenderSettings::default(),
            expect: None,
            warnings: Vec::new(),
            filter: PixelFilter::default(),
            light_groups: LightGroups::default(),
        }
    }
}

impl Scene {
    /// Reads a scene file (`.toml`, `.gltf` or `.glb`); see [`load`].
    ///
    /// # Errors
    /// The file, a field in it, or a file that it names is not what it has to be.
    pub fn load(
        path: impl AsRef<std::path::Path>,
        options: &load::LoadOptions,
    ) -> Result<Self, crate::error::Error> {
        load::load(path.as_ref(), options)
    }

    /// Adds a material.
    pub fn add_material(&mut self, name: &str, bsdf: Bsdf) -> MaterialId {
        let id = MaterialId(self.materials.len() as u32);
        self.materials.push(Material::new(name, bsdf));
        id
    }

    /// Adds a shape that does not emit; its name is in messages and AOVs.
    pub fn add_shape(&mut self, name: &str, geometry: Geometry, material: MaterialId) {
        self.shapes.push(Shape {
            name: name.to_owned(),
            geometry,
            material,
            emission: None,
        });
    }

    /// Adds a shape whose front emits `radiance` (W·sr⁻¹·m⁻²).
    pub fn add_area_light(
        &mut self,
        name: &str,
        geometry: Geometry,
        material: MaterialId,
        radiance: glam::DVec3,
    ) {
        self.add_shape(name, geometry, material);
        let shape = self.shapes.last_mut().expect("it was added");
        shape.emission = Some(Emission {
            radiance,
            two_sided: false,
            texture: None,
        });
    }

    /// Light samples that a camera ray takes with light selection `all`: each primitive that emits
    /// and the environment have as many as there are shadow rays, where the strategy samples them;
    /// lights without a surface, which nothing else reaches, have one.
    pub fn samples_of_all_lights(&self, settings: &RenderSettings) -> u64 {
        let is_sun = |light: &&Light| matches!(light, Light::Sun(_));
        let suns = self.lights.iter().filter(is_sun).count() as u64;
        let mut samples = self.lights.len() as u64 - suns;
        if settings.estimator.strategy.samples_lights() {
            let lit = |e: Emission| e.radiance.max_element() > 0.0;
            let emitting = self.shapes.iter().filter(|s| s.emission.is_some_and(lit));
            let primitives: u64 = emitting.map(|s| s.geometry.primitives()).sum();
            let environments = u64::from(self.environment.is_some());
            samples += (primitives + suns + environments)
                * u64::from(settings.estimator.shadow_rays.least());
        }
        samples
    }
}
