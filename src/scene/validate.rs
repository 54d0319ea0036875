//! Checks what types cannot say.
//!
//! Loaded and programmatic scenes pass through here before anything is rendered; what comes behind
//! may rely on it.

mod materials;
mod view;

use super::ellipsoid::PrincipalAxes;
use super::light_groups::MAX_LIGHT_GROUPS;
use super::range;
use super::settings::MAX_SPECULAR_DEPTH;
use super::shadow_rays::{MAX_LIGHT_SAMPLES, MAX_SHADOW_RAYS};
use super::{
    Emission, Environment, EnvironmentRadiance, Expect, ExpectedRadiance, FilmSize, Geometry,
    LightGroups, LightSelection, Material, Mesh, RenderSettings, Scene, Shape,
};
use crate::error::{Error, InputError};
use glam::{DMat3, DVec3};

/// Checks a whole scene: every number in its domain, every index in range, no geometry without
/// extent.
///
/// # Errors
/// [`Error::Input`] with [`Scene::source`] as the file and a field as the TOML format names it.
pub fn validate(scene: &Scene) -> Result<(), Error> {
    let check = Check {
        file: &scene.source,
    };
    check.film(scene.film)?;
    check.camera(&scene.camera)?;
    check.filter(&scene.filter)?;
    for (index, texture) in scene.textures.iter().enumerate() {
        materials::texels(&scene.source, texture, index)?;
    }
    for material in &scene.materials {
        materials::check(&scene.source, material)?;
        materials::textures(&scene.source, material, scene.textures.len())?;
    }
    for shape in &scene.shapes {
        check.shape(shape, &scene.materials)?;
        if let Some(used) = shape.emission.and_then(|e| e.texture) {
            let field = format!("{}.emission.texture", shape.field());
            materials::texture_use(&scene.source, used, scene.textures.len(), &field)?;
        }
    }
    for (index, light) in scene.lights.iter().enumerate() {
        let field = format!("lights[{index}]");
        light
            .check()
            .map_err(|fault| fault.at(&scene.source, &field))?;
    }
    if let Some(environment) = &scene.environment {
        check.environment(environment)?;
    }
    check.light_groups(&scene.light_groups)?;
    check.settings(scene, &scene.render)?;
    if let Some(expect) = &scene.expect {
        check.expect(expect, scene.film)?;
    }
    Ok(range::check(scene)?)
}

/// Checks whether a scene can be rendered by `settings`.
///
/// # Errors
/// They are out of their domain, or the scene has too many lights for them.
pub fn settings(scene: &Scene, settings: &RenderSettings) -> Result<(), InputError> {
    let check = Check {
        file: &scene.source,
    };
    check.settings(scene, settings)
}

/// The largest ratio of an ellipsoid's half axes: the square of their product, in units of the
/// longest, is a normal number of f32.
const MAX_ASPECT: f64 = 1e9;

/// Makes errors about one file.
struct Check<'a> {
    file: &'a std::path::Path,
}

type Outcome = Result<(), InputError>;

impl Check<'_> {
    fn require(
        &self,
        holds: bool,
        field: impl FnOnce() -> String,
        problem: impl FnOnce() -> String,
        expected: &str,
    ) -> Outcome {
        if holds {
            Ok(())
        } else {
            Err(InputError::new(self.file, field(), problem(), expected))
        }
    }

    fn shape(&self, shape: &Shape, materials: &[Material]) -> Outcome {
        let field = shape.field();
        if let Some(Emission { radiance, .. }) = shape.emission {
            self.power(radiance, || format!("{field}.emission.radiance"))?;
        }
        self.require(
            shape.material.index() < materials.len(),
            || format!("{field}.material"),
            || format!("is {} of {}", shape.material.0, materials.len()),
            "an index into the scene's materials",
        )?;
        let two_sided = shape.emission.is_some_and(|e| e.two_sided);
        let opacity = materials[shape.material.index()].opacity.untextured();
        let sphere = matches!(
            shape.geometry,
            Geometry::Sphere { .. } | Geometry::Ellipsoid { .. }
        );
        self.require(
            !(sphere && two_sided) || opacity >= 1.0,
            || format!("{field}.emission.two_sided"),
            || format!("is true on a sphere of opacity {opacity}"),
            "false: a sphere that rays pass emits outwards only",
        )?;
        match &shape.geometry {
            Geometry::Rectangle { corner: p, u, v } | Geometry::Disk { center: p, u, v } => self
                .require(
                    p.is_finite()
                        && u.is_finite()
                        && v.is_finite()
                        && u.cross(*v).length() > 1e-12 * u.length() * v.length(),
                    || field.to_owned(),
                    || format!("has no area: `u` {u}, `v` {v}"),
                    "finite edges in different directions",
                ),
            Geometry::Sphere { center, radius } => self.require(
                center.is_finite() && *radius > 0.0 && radius.is_finite(),
                || format!("{field}.radius"),
                || format!("is {radius}"),
                "a finite centre, and a radius above 0",
            ),
            Geometry::Ellipsoid { center, axes } => self.ellipsoid(*center, *axes, field),
            Geometry::Mesh(mesh) => self.mesh(mesh, field),
        }
    }

    fn ellipsoid(&self, center: DVec3, axes: DMat3, field: &str) -> Outcome {
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis];
        let volume: f64 = columns.iter().map(|axis| axis.length()).product();
        self.require(
            center.is_finite() && axes.is_finite() && axes.determinant().abs() > 1e-12 * volume,
            || field.to_owned(),
            || format!("has no volume: `axes` {axes}"),
            "a finite centre, and finite axes that do not lie in a plane",
        )?;
        let radii = PrincipalAxes::of(axes).radii;
        self.require(
            radii.max_element() <= MAX_ASPECT * radii.min_element(),
            || format!("{field}.transform"),
            || {
                format!(
                    "makes an ellipsoid with half axes of {:e}, {:e} and {:e}",
                    radii.x, radii.y, radii.z
                )
            },
            "half axes that differ by a factor of 1e9 at most; a disk has no thickness",
        )
    }

    fn light_groups(&self, groups: &LightGroups) -> Outcome {
        let groups = groups.names().len();
        self.require(
            // One more may be that of the lights without a name.
            groups < MAX_LIGHT_GROUPS,
            || "group".to_owned(),
            || format!("has {groups} different names in the scene"),
            "at most 63 groups of lights",
        )
    }

    fn mesh(&self, mesh: &Mesh, field: &str) -> Outcome {
        let finite = mesh.positions.iter().position(|p| !p.is_finite());
        self.require(
            finite.is_none(),
            || field.to_owned(),
            || format!("vertex {} is not finite", finite.unwrap_or_default()),
            "finite positions",
        )?;
        let outside = mesh
            .triangles
            .iter()
            .flatten()
            .find(|i| **i as usize >= mesh.positions.len());
        self.require(
            outside.is_none(),
            || field.to_owned(),
            || format!("vertex index {} is out of range", outside.unwrap_or(&0)),
            "indices below the number of positions",
        )?;
        for (count, what) in [
            (mesh.normals.len(), "normals"),
            (mesh.uvs.len(), "texture coordinates"),
            (mesh.second_uvs.len(), "second texture coordinates"),
            (mesh.colors.len(), "colours"),
            (mesh.tangents.len(), "tangents"),
        ] {
            self.require(
                count == 0 || count == mesh.positions.len(),
                || field.to_owned(),
                || format!("has {count} {what} for {} positions", mesh.positions.len()),
                "as many as positions, or none",
            )?;
        }
        let factor = |c: &f32| (0.0..=1.0).contains(c);
        let outside = mesh
            .colors
            .iter()
            .position(|c| !c.to_array().iter().all(factor));
        self.require(
            outside.is_none(),
            || field.to_owned(),
            || {
                format!(
                    "the colour of vertex {} is not a factor",
                    outside.unwrap_or_default()
                )
            },
            "each channel from 0 to 1",
        )
    }

    fn power(&self, value: DVec3, field: impl FnOnce() -> String) -> Outcome {
        self.require(
            value.is_finite() && value.cmpge(DVec3::ZERO).all(),
            field,
            || format!("is {value}"),
            "finite numbers, not negative",
        )
    }

    fn environment(&self, environment: &Environment) -> Outcome {
        let scale = environment.scale;
        self.require(
            scale.is_finite() && scale >= 0.0,
            || "environment.scale".to_owned(),
            || format!("is {scale}"),
            "a finite number, not negative",
        )?;
        self.require(
            is_rotation(environment.rotation),
            || "environment.rotation".to_owned(),
            || "is not a rotation".to_owned(),
            "a finite angle, or an orthonormal matrix",
        )?;
        match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => {
                self.power(*radiance, || "environment.radiance".to_owned())
            }
            EnvironmentRadiance::Map(map) => {
                let texels = map.width as usize * map.height as usize;
                self.require(
                    texels > 0 && map.texels.len() == texels,
                    || "environment.file".to_owned(),
                    || format!("has {} texels", map.texels.len()),
                    "width times height, and at least 1",
                )?;
                let valid = |c: &f32| c.is_finite() && *c >= 0.0;
                self.require(
                    map.texels.iter().flatten().all(valid),
                    || "environment.file".to_owned(),
                    || "has texels that are negative or not finite".to_owned(),
                    "finite numbers, not negative",
                )
            }
        }
    }

    fn settings(&self, scene: &Scene, render: &RenderSettings) -> Outcome {
        self.require(
            render.stop.spp >= 1,
            || "render.spp".to_owned(),
            || format!("is {}", render.stop.spp),
            "at least 1 sample per pixel",
        )?;
        let time = render.stop.time.unwrap_or(1.0);
        self.require(
            time > 0.0 && time.is_finite(),
            || "render.time".to_owned(),
            || format!("is {time}"),
            "seconds, above 0",
        )?;
        let error = render.stop.error.unwrap_or(1.0);
        self.require(
            error > 0.0 && error.is_finite(),
            || "render.error".to_owned(),
            || format!("is {error}"),
            "a relative error such as 0.01, above 0",
        )?;
        let confidence = render.stop.confidence;
        self.require(
            confidence > 0.0 && confidence < 1.0,
            || "render.confidence".to_owned(),
            || format!("is {confidence}"),
            "a probability such as 0.95, above 0 and below 1",
        )?;
        let rays = render.estimator.shadow_rays;
        self.require(
            (1..=MAX_SHADOW_RAYS).contains(&rays.most()),
            || "render.shadow_rays".to_owned(),
            || format!("is {rays}"),
            "\"auto\" or 1 to 1024",
        )?;
        let depth = render.estimator.max_specular_depth;
        self.require(
            depth <= MAX_SPECULAR_DEPTH,
            || "render.max_specular_depth".to_owned(),
            || format!("is {depth}"),
            "0 to 64",
        )?;
        let samples = match render.estimator.light_selection {
            LightSelection::All => scene.samples_of_all_lights(render),
            LightSelection::Auto
            | LightSelection::Uniform
            | LightSelection::Power
            | LightSelection::Tree => u64::from(rays.least()),
        };
        self.require(
            samples <= MAX_LIGHT_SAMPLES,
            || "render.light_selection".to_owned(),
            || format!("is \"all\", which takes {samples} shadow rays per camera ray here"),
            "at most 65535 of them: fewer shadow_rays, or \"tree\", \"power\" or \"uniform\"",
        )
    }

    fn expect(&self, expect: &Expect, film: FilmSize) -> Outcome {
        match &expect.radiance {
            ExpectedRadiance::Mean(mean) => self.power(*mean, || "expect.radiance".to_owned())?,
            ExpectedRadiance::Pixels(pixels) => {
                self.require(
                    pixels.len() == film.pixels(),
                    || "expect.pixels".to_owned(),
                    || format!("has {} values", pixels.len()),
                    "as many as the film has pixels",
                )?;
                for (i, &pixel) in pixels.iter().enumerate() {
                    let (x, y) = (i % film.width as usize, i / film.width as usize);
                    self.power(pixel, || format!("expect.pixels[{y}][{x}]"))?;
                }
            }
        }
        let tolerance = expect.tolerance;
        self.require(
            (0.0..1.0).contains(&tolerance),
            || "expect.tolerance".to_owned(),
            || format!("is {tolerance}"),
            "a relative difference from 0 to below 1",
        )?;
        self.require(
            !expect.source.trim().is_empty(),
            || "expect.source".to_owned(),
            || "is empty".to_owned(),
            "where the value comes from: a formula, a paper, a book",
        )
    }
}

/// Whether the columns are orthonormal, finite and right-handed.
fn is_rotation(m: DMat3) -> bool {
    let off = m.transpose() * m - DMat3::IDENTITY;
    off.to_cols_array().iter().all(|x| x.abs() < 1e-6) && m.determinant() > 0.0
}
