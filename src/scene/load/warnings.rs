//! What is legal but probably not meant.

use crate::scene::ellipsoid::half_extent;
use crate::scene::normalize::Normalization;
use crate::scene::refine::coarse_shapes;
use crate::scene::{Bsdf, EnvironmentRadiance, Geometry, Scene, Shape};
use glam::DVec3;

/// Largest coordinate of a sphere over its distance from what is in view: rays leave it 2⁻²⁰ of
/// that coordinate off it, at this ratio 2⁻⁶ of the distance.
const MAX_COARSENESS: f64 = 16_384.0;
/// Radiance below this is 0 in the image's 32-bit numbers.
const LEAST: f64 = f32::MIN_POSITIVE as f64;

/// One sentence each about what is legal in `scene` but probably not meant.
pub(super) fn general(scene: &Scene) -> Vec<String> {
    let normalization = Normalization::of(scene);
    let mut warnings = Vec::new();
    warnings.extend(darkness(scene, &normalization));
    warnings.extend(coarse_spheres(scene, &normalization));
    warnings.extend(coarse_meshes(scene, &normalization));
    warnings.extend(far_from_origin(scene, &normalization));
    warnings.extend(empty_meshes(scene));
    warnings
}

/// A light, as a message names it, and the most radiance or irradiance that it can bring.
struct Brightness {
    name: String,
    most: f64,
}

/// Why the image will be black, whatever is rendered.
fn darkness(scene: &Scene, normalization: &Normalization) -> Option<String> {
    let lights = brightness(scene, normalization);
    if lights.is_empty() {
        return Some("the scene has no light: the image will be black".to_owned());
    }
    if lights.iter().any(|light| light.most >= LEAST) {
        return None;
    }
    let names: Vec<&str> = lights.iter().map(|light| light.name.as_str()).collect();
    let names = names.join(", ");
    let brightest = lights.iter().map(|light| light.most).fold(0.0, f64::max);
    Some(if brightest > 0.0 {
        format!(
            "the scene's light is so weak, about {brightest:.1e}, that 32-bit numbers hold it as 0 ({names}): the image will be black"
        )
    } else {
        format!("nothing in the scene emits light ({names}): the image will be black")
    })
}

fn brightness(scene: &Scene, normalization: &Normalization) -> Vec<Brightness> {
    let mut found = Vec::new();
    for shape in &scene.shapes {
        found.extend(of_shape(scene, shape, normalization));
    }
    for (index, light) in scene.lights.iter().enumerate() {
        found.push(Brightness {
            name: format!("lights[{index}].{}", light.strength_key()),
            most: light.normalized(normalization).strength().max_element(),
        });
    }
    if let Some(environment) = &scene.environment {
        let largest = match &environment.radiance {
            EnvironmentRadiance::Constant(radiance) => radiance.max_element(),
            EnvironmentRadiance::Map(map) => {
                let channels = map.texels.iter().flatten().copied();
                f64::from(channels.fold(0.0, f32::max))
            }
        };
        let key = if environment.scale > 0.0 {
            "radiance"
        } else {
            "scale"
        };
        found.push(Brightness {
            name: format!("environment.{key}"),
            most: largest * environment.scale,
        });
    }
    found
}

/// That of a shape that was meant to emit, or that shows its colour.
fn of_shape(scene: &Scene, shape: &Shape, normalization: &Normalization) -> Option<Brightness> {
    let material = &scene.materials[shape.material.index()];
    if let Bsdf::Unlit { color } = material.bsdf {
        let met = !material.opacity.is_never_met();
        return Some(Brightness {
            name: format!("materials.{}.color", material.name),
            most: if met { color.max_element() } else { 0.0 },
        });
    }
    let emission = shape.emission?;
    let field = shape.field();
    if scene.materials[shape.material.index()]
        .opacity
        .is_never_met()
    {
        return Some(Brightness {
            name: format!("the opacity of {field}"),
            most: 0.0,
        });
    }
    let texture = emission
        .texture
        .map(|used| &scene.textures[used.texture.index()]);
    let radiance = emission.radiance.max_element() * texture.map_or(1.0, |t| t.largest());
    let size = normalization.length(size(&shape.geometry)) / normalization.radius;
    Some(Brightness {
        name: format!("{field}.emission"),
        most: radiance * size.min(1.0).powi(2),
    })
}

/// The longest side of the box around it.
fn size(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Rectangle { u, v, .. } => u.length().max(v.length()),
        Geometry::Disk { u, v, .. } => 2.0 * u.length().max(v.length()),
        Geometry::Sphere { radius, .. } => 2.0 * radius,
        Geometry::Ellipsoid { axes, .. } => 2.0 * half_extent(*axes).max_element(),
        Geometry::Mesh(mesh) => {
            let (low, high) = mesh.bounds().unwrap_or_default();
            (high - low).max_element()
        }
    }
}

/// Spheres whose surface is near, while their middle is so far that f32 cannot tell where the
/// surface is.
fn coarse_spheres(scene: &Scene, normalization: &Normalization) -> Vec<String> {
    let spheres = scene.shapes.iter().filter_map(|shape| {
        let (center, radius, field) = match shape.geometry {
            Geometry::Sphere { center, radius } => (center, radius, "radius: is"),
            Geometry::Ellipsoid { center, axes } => {
                let to_view = (normalization.center - center).normalize_or(DVec3::X);
                (center, (axes.inverse() * to_view).length().recip(), "transform: makes a half axis of")
            }
            _ => return None,
        };
        let middle = (center - normalization.center).length();
        let near = normalization.radius / normalization.scale;
        let distance = (middle - radius).abs().max(near);
        let coarseness = (middle + radius) / distance;
        (coarseness > MAX_COARSENESS).then(|| {
            format!(
                "{}.{field} {radius:e}, {coarseness:.0e} times what is in view there, which 32-bit coordinates do not resolve: \
                 its light and shadows will be wrong; a smaller sphere, a disk or a mesh is needed",
                shape.field()
            )
        })
    });
    spheres.collect()
}

/// Meshes of an extreme scene with too many large triangles to cut all of them.
fn coarse_meshes(scene: &Scene, normalization: &Normalization) -> Option<String> {
    let extreme = normalization.is_extreme();
    let coarse = extreme.then(|| coarse_shapes(scene, normalization));
    let names = coarse.filter(|names| !names.is_empty())?.join(", ");
    Some(format!(
        "{names}: too many of its triangles are large beside their distance from what is in view, which 32-bit coordinates do not \
         resolve: light and shadows near them may be wrong; smaller triangles are needed there"
    ))
}

/// Where f64 has too few digits for what is in view.
fn far_from_origin(scene: &Scene, normalization: &Normalization) -> Option<String> {
    let distance = normalization.center.abs().max_element();
    let near = normalization.radius / normalization.scale;
    let extreme = normalization.is_extreme() && !scene.shapes.is_empty();
    (extreme && distance * f64::EPSILON > near * 1e-4).then(|| {
        format!(
            "camera.eye: what is in view is {near:.1e} in size and lies {distance:.1e} from the origin, where the file's \
             coordinates have too few digits for it: nearer to the origin it would be exact"
        )
    })
}

fn empty_meshes(scene: &Scene) -> Option<String> {
    let is_empty = |s: &&Shape| matches!(&s.geometry, Geometry::Mesh(m) if m.triangles.is_empty());
    match scene.shapes.iter().filter(is_empty).count() {
        0 => None,
        1 => Some("1 mesh has no triangle".to_owned()),
        empty => Some(format!("{empty} meshes have no triangle")),
    }
}
