//! KHR_lights_punctual, with its units: candela for points and spots, lux for directional lights.

use super::document::Document;
use super::nodes::Placed;
use crate::error::InputError;
use crate::scene::{DirectionalLight, Light, PointLight, SpotLight};
use glam::{DAffine3, DVec3};
use gltf::json::extensions::scene::khr_lights_punctual as khr;
use gltf::json::validation::Checked;
use std::f64::consts::FRAC_PI_2;

/// The lights of all placed nodes, moved by `placement`, which leaves their intensities as they
/// are.
pub(super) fn all(
    document: &Document,
    placed: &[Placed],
    placement: &DAffine3,
) -> Result<Vec<Light>, InputError> {
    let mut lights = Vec::new();
    for node in placed {
        let Some(index) = light_of(document, node) else {
            continue;
        };
        let light = document.get(list(document), index, "light", || {
            format!("nodes[{}].extensions.KHR_lights_punctual.light", node.index)
        })?;
        let field = format!("extensions.KHR_lights_punctual.lights[{index}]");
        let to_world = *placement * node.to_world;
        lights.push(convert(document, light, &field, node, &to_world)?);
    }
    Ok(lights)
}

/// The lights of the file.
pub(super) fn list(document: &Document) -> &[khr::Light] {
    document
        .root
        .extensions
        .as_ref()
        .and_then(|e| e.khr_lights_punctual.as_ref())
        .map_or(&[], |e| &e.lights)
}

/// The index of the light that a node shows.
pub(super) fn light_of(document: &Document, node: &Placed) -> Option<usize> {
    if !node.visible {
        return None;
    }
    let extensions = document.root.nodes[node.index].extensions.as_ref()?;
    Some(extensions.khr_lights_punctual.as_ref()?.light.value())
}

fn convert(
    document: &Document,
    light: &khr::Light,
    field: &str,
    node: &Placed,
    to_world: &DAffine3,
) -> Result<Light, InputError> {
    let position = to_world.translation;
    let refuse = |problem: &str| {
        let field = format!("nodes[{}]", node.index);
        document.error(field, problem, "an invertible transform")
    };
    if !position.is_finite() {
        return Err(refuse("its transform leaves its light no position"));
    }
    let direction = to_world.transform_vector3(DVec3::NEG_Z).try_normalize();
    let direction =
        || direction.ok_or_else(|| refuse("its transform leaves its light no direction"));
    let power = power(document, light, field)?;
    match light.type_ {
        Checked::Valid(khr::Type::Point) => Ok(Light::Point(PointLight {
            position,
            intensity: power,
        })),
        Checked::Valid(khr::Type::Directional) => Ok(Light::Directional(DirectionalLight {
            direction: direction()?,
            irradiance: power,
        })),
        Checked::Valid(khr::Type::Spot) => {
            let (inner_angle, outer_angle) = cone(document, light, field)?;
            Ok(Light::Spot(SpotLight {
                position,
                direction: direction()?,
                intensity: power,
                inner_angle,
                outer_angle,
            }))
        }
        Checked::Invalid => Err(document.error(
            format!("{field}.type"),
            "is unknown",
            "point, spot or directional",
        )),
    }
}

/// The half angles of full intensity and of none, in radians.
fn cone(document: &Document, light: &khr::Light, field: &str) -> Result<(f64, f64), InputError> {
    let spot = light.spot.as_ref().ok_or_else(|| {
        document.error(
            format!("{field}.spot"),
            "is missing",
            "the cone of the spot light",
        )
    })?;
    let inner_angle = f64::from(spot.inner_cone_angle);
    // π/2 in f32 lies above π/2.
    let outer_angle = f64::from(spot.outer_cone_angle) - 1e-7;
    let outer_angle = if outer_angle <= FRAC_PI_2 {
        f64::from(spot.outer_cone_angle).min(FRAC_PI_2)
    } else {
        f64::NAN
    };
    if !(0.0 <= inner_angle && inner_angle <= outer_angle && outer_angle > 0.0) {
        return Err(document.error(
            format!("{field}.spot"),
            format!(
                "innerConeAngle is {} and outerConeAngle {}",
                spot.inner_cone_angle, spot.outer_cone_angle
            ),
            "0 <= inner < outer <= π/2",
        ));
    }
    Ok((inner_angle, outer_angle))
}

/// Colour times intensity.
fn power(document: &Document, light: &khr::Light, field: &str) -> Result<DVec3, InputError> {
    let color = DVec3::from_array(light.color.map(f64::from));
    let intensity = f64::from(light.intensity);
    for (value, what) in [
        (intensity, "intensity"),
        (color.min_element(), "color"),
        (color.max_element(), "color"),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(document.error(
                format!("{field}.{what}"),
                format!("is {value}"),
                "a finite number, not negative",
            ));
        }
    }
    Ok(color * intensity)
}
