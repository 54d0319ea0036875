//! Cameras: the first one of the default scene.

use super::document::Document;
use super::nodes::Placed;
use crate::error::InputError;
use crate::scene::{Camera, Projection};
use glam::{DAffine3, DVec3};
use gltf::json;

/// The scene's first camera, moved by `placement`; scale and mirroring of its node are ignored, as
/// glTF has it, while `placement` scales what an orthographic one sees. Its aspect is the image's:
/// the vertical size decides.
pub(super) fn first(
    document: &Document,
    placed: &[Placed],
    placement: &DAffine3,
) -> Result<Option<Camera>, InputError> {
    for node in placed {
        let Some(index) = document.root.nodes[node.index].camera.map(|c| c.value()) else {
            continue;
        };
        let camera = document.get(&document.root.cameras, index, "camera", || {
            format!("nodes[{}].camera", node.index)
        })?;
        let Some(projection) = projection(document, index, camera, placement)? else {
            continue;
        };
        let to_world = *placement * node.to_world;
        let forward = to_world.transform_vector3(DVec3::NEG_Z);
        let up = to_world.transform_vector3(DVec3::Y);
        let camera = Camera::look_at(DVec3::ZERO, forward, up, 1.0)
            .filter(|_| to_world.translation.is_finite())
            .ok_or_else(|| {
                document.error(
                    format!("nodes[{}]", node.index),
                    "its transform leaves its camera no direction",
                    "an invertible transform",
                )
            })?;
        return Ok(Some(Camera {
            eye: to_world.translation,
            projection,
            ..camera
        }));
    }
    Ok(None)
}

/// The projection of camera `index`; `None` for a camera without one.
fn projection(
    document: &Document,
    index: usize,
    camera: &json::Camera,
    placement: &DAffine3,
) -> Result<Option<Projection>, InputError> {
    let refuse = |field: &str, value: f64, expected: &str| {
        let field = format!("cameras[{index}].{field}");
        Err(document.error(field, format!("is {value}"), expected))
    };
    if let Some(perspective) = &camera.perspective {
        let fov_y = f64::from(perspective.yfov);
        if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
            let expected = "an angle above 0 and below π, in radians";
            return refuse("perspective.yfov", fov_y, expected);
        }
        return Ok(Some(Projection::Perspective { fov_y }));
    }
    let Some(orthographic) = &camera.orthographic else {
        return Ok(None);
    };
    let half = f64::from(orthographic.ymag);
    if !(half > 0.0 && half.is_finite()) {
        let expected = "half the height of what is seen, above 0";
        return refuse("orthographic.ymag", half, expected);
    }
    let scale = placement.matrix3.determinant().abs().cbrt();
    Ok(Some(Projection::Orthographic {
        height: 2.0 * half * scale,
    }))
}
