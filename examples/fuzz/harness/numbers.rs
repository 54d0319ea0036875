//! Every number of a scene, to be replaced by any other: scenes that no file could describe, for
//! `validate`.

use direkt::scene::{
    Bsdf, DirectionalLight, EnvironmentRadiance, ExpectedRadiance, Geometry, Light, Material,
    PointLight, Projection, Scene, Shape, SpotLight, SunLight,
};
use glam::DVec3;

/// Calls `visit` with each number in turn; what it leaves is taken back, rounded where the scene
/// has an integer.
pub fn visit(scene: &mut Scene, visit: &mut impl FnMut(f64) -> f64) {
    let visit = &mut Visitor(visit);
    let camera = &mut scene.camera;
    visit.vector(&mut camera.eye);
    visit.vector(&mut camera.right);
    visit.vector(&mut camera.up);
    visit.vector(&mut camera.forward);
    match &mut camera.projection {
        Projection::Perspective { fov_y: size } | Projection::Orthographic { height: size } => {
            visit.number(size);
        }
    }
    visit.number(&mut camera.lens.radius);
    visit.number(&mut camera.lens.focus_distance);
    visit.number(&mut scene.filter.radius);
    visit.number(&mut scene.filter.stddev);
    visit.integer(&mut scene.film.width);
    visit.integer(&mut scene.film.height);
    for m in &mut scene.materials {
        visit.material(m);
    }
    for shape in &mut scene.shapes {
        visit.shape(shape);
    }
    for light in &mut scene.lights {
        visit.light(light);
    }
    if let Some(environment) = &mut scene.environment {
        visit.number(&mut environment.scale);
        for column in 0..3 {
            visit.vector(environment.rotation.col_mut(column));
        }
        if let EnvironmentRadiance::Constant(radiance) = &mut environment.radiance {
            visit.vector(radiance);
        }
    }
    let render = &mut scene.render;
    if let direkt::scene::ShadowRays::Number(rays) = &mut render.estimator.shadow_rays {
        visit.integer(rays);
    }
    visit.number(&mut render.stop.confidence);
    for limit in [&mut render.stop.time, &mut render.stop.error]
        .into_iter()
        .flatten()
    {
        visit.number(limit);
    }
    if let Some(expect) = &mut scene.expect {
        visit.number(&mut expect.tolerance);
        match &mut expect.radiance {
            ExpectedRadiance::Mean(mean) => visit.vector(mean),
            ExpectedRadiance::Pixels(pixels) => pixels.iter_mut().for_each(|p| visit.vector(p)),
        }
    }
}

struct Visitor<'a, F>(&'a mut F);

impl<F: FnMut(f64) -> f64> Visitor<'_, F> {
    fn number(&mut self, x: &mut f64) {
        *x = (self.0)(*x);
    }

    fn integer(&mut self, n: &mut u32) {
        *n = (self.0)(f64::from(*n)) as u32;
    }

    fn vector(&mut self, v: &mut DVec3) {
        *v = DVec3::from_array(v.to_array().map(&mut *self.0));
    }

    fn material(&mut self, material: &mut Material) {
        match &mut material.bsdf {
            Bsdf::Lambert { reflectance } | Bsdf::Mirror { reflectance } => {
                self.vector(reflectance);
            }
            Bsdf::Unlit { color } => self.vector(color),
            Bsdf::SpecularGlossiness {
                diffuse,
                specular,
                glossiness,
                ..
            } => {
                self.vector(diffuse);
                self.vector(specular);
                self.number(glossiness);
            }
            Bsdf::Dielectric {
                ior, transmittance, ..
            } => {
                self.number(ior);
                self.vector(transmittance);
            }
            Bsdf::Metal { eta, k, alpha } => {
                self.vector(eta);
                self.vector(k);
                self.number(alpha);
            }
            Bsdf::Plastic {
                reflectance,
                ior,
                alpha,
            } => {
                self.vector(reflectance);
                self.number(ior);
                self.number(alpha);
            }
            Bsdf::Conductor { reflectance, alpha } => {
                self.vector(reflectance);
                self.number(alpha);
            }
            Bsdf::MetallicRoughness {
                base_color,
                metallic,
                roughness,
                layer,
            } => {
                self.vector(base_color);
                self.number(metallic);
                self.number(roughness);
                self.number(&mut layer.ior);
                self.number(&mut layer.specular);
                self.vector(&mut layer.specular_color);
                self.number(&mut layer.transmission);
            }
        }
    }

    fn shape(&mut self, shape: &mut Shape) {
        self.integer(&mut shape.material.0);
        if let Some(emission) = &mut shape.emission {
            self.vector(&mut emission.radiance);
        }
        match &mut shape.geometry {
            Geometry::Rectangle { corner: p, u, v } | Geometry::Disk { center: p, u, v } => {
                [p, u, v].into_iter().for_each(|x| self.vector(x));
            }
            Geometry::Sphere { center, radius } => {
                self.vector(center);
                self.number(radius);
            }
            Geometry::Ellipsoid { center, axes } => {
                let columns = [&mut axes.x_axis, &mut axes.y_axis, &mut axes.z_axis];
                columns.into_iter().for_each(|axis| self.vector(axis));
                self.vector(center);
            }
            Geometry::Mesh(mesh) => {
                mesh.positions.iter_mut().for_each(|p| self.vector(p));
                let corners = mesh.triangles.iter_mut().flatten();
                corners.for_each(|i| self.integer(i));
            }
        }
    }

    fn light(&mut self, light: &mut Light) {
        match light {
            Light::Point(PointLight {
                position,
                intensity,
            }) => {
                self.vector(position);
                self.vector(intensity);
            }
            Light::Spot(SpotLight {
                position,
                direction,
                intensity,
                inner_angle,
                outer_angle,
            }) => {
                [position, direction, intensity]
                    .into_iter()
                    .for_each(|x| self.vector(x));
                self.number(inner_angle);
                self.number(outer_angle);
            }
            Light::Directional(DirectionalLight {
                direction,
                irradiance,
            }) => {
                self.vector(direction);
                self.vector(irradiance);
            }
            Light::Sun(SunLight {
                direction,
                irradiance,
                angular_radius,
            }) => {
                self.vector(direction);
                self.vector(irradiance);
                self.number(angular_radius);
            }
        }
    }
}
