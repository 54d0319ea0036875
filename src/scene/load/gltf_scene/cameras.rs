//! Cameras: the first perspective one of the default scene.

use super::document::Document;
use super::nodes::Placed;
use crate::error::InputError;
use crate::scene::Camera;
use glam::{DAffine3, DVec3};

/// The scene's first perspective camera, moved by `placement`; scale and mirroring of its node are ignored.
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
        let Some(perspective) = &camera.perspective else {
            continue;
        };
        let fov_y = f64::from(perspective.yfov);
        if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
            return Err(document.error(
                format!("cameras[{index}].perspective.yfov"),
                format!("is {fov_y}"),
                "an angle above 0 and below π, in radians",
            ));
        }
        let to_world = *placement * node.to_world;
        let forward = to_world.transform_vector3(DVec3::NEG_Z);
        let up = to_world.transform_vector3(DVec3::Y);
        let camera = Camera::look_at(DVec3::ZERO, forward, up, fov_y)
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
            ..camera
        }));
    }
    Ok(None)
}
