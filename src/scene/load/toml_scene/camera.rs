//! The tables `[camera]` and `[film]`.

use super::build::{Context, affine};
use super::format::{CameraKind, CameraTable, FilmTable};
use crate::error::InputError;
use crate::scene::filter::FilterKind;
use crate::scene::{Camera, FilmSize, Lens, PixelFilter, Projection};
use glam::{DMat3, DVec3};

/// The size of the image.
pub(super) fn film(context: &Context, table: &FilmTable) -> Result<FilmSize, InputError> {
    let side = |value: i64, key: &str| {
        u32::try_from(value)
            .ok()
            .filter(|v| (1..=FilmSize::MAX_SIDE).contains(v))
            .ok_or_else(|| {
                context.error(
                    format!("film.{key}"),
                    format!("is {value}"),
                    format!("1 to {} pixels", FilmSize::MAX_SIDE),
                )
            })
    };
    Ok(FilmSize {
        width: side(table.width, "width")?,
        height: side(table.height, "height")?,
    })
}

/// The pixel filter; `validate` checks its numbers.
pub(super) fn filter(context: &Context, table: &FilmTable) -> Result<PixelFilter, InputError> {
    if let (Some(_), true) = (table.filter_stddev, table.filter != FilterKind::Gaussian) {
        return Err(context.error(
            "film.filter_stddev",
            format!(
                "is given for the filter \"{}\", which has none",
                table.filter
            ),
            "filter = \"gaussian\"",
        ));
    }
    let usual = PixelFilter::of_kind(table.filter);
    Ok(PixelFilter {
        radius: table.filter_radius.unwrap_or(usual.radius),
        stddev: table.filter_stddev.unwrap_or(usual.stddev),
        ..usual
    })
}

/// The camera.
pub(super) fn camera(context: &Context, table: &CameraTable) -> Result<Camera, InputError> {
    let projection = projection(context, table)?;
    let placed = placed(context, table)?;
    let target = table.eye.zip(table.target);
    let to_target = target.map(|(e, t)| DVec3::from_array(t).distance(DVec3::from_array(e)));
    let has_lens = table.lens_radius > 0.0;
    let focus_distance = table.focus_distance.or(to_target.filter(|_| has_lens));
    if has_lens && focus_distance.is_none() {
        return Err(context.error(
            "camera.focus_distance",
            "is missing, and there is no `target` that could be sharp",
            "the distance from the eye, along the viewing direction, of the plane that is sharp",
        ));
    }
    Ok(Camera {
        projection,
        lens: Lens {
            radius: table.lens_radius,
            focus_distance: focus_distance.unwrap_or(Lens::PINHOLE.focus_distance),
        },
        ..placed
    })
}

fn projection(context: &Context, table: &CameraTable) -> Result<Projection, InputError> {
    let (wanted, other, name) = match table.kind {
        CameraKind::Perspective => (table.fov, table.height, ["fov", "height", "perspective"]),
        CameraKind::Orthographic => (table.height, table.fov, ["height", "fov", "orthographic"]),
    };
    let [key, other_key, kind] = name;
    if other.is_some() {
        let problem = format!("is given for a camera of type \"{kind}\", which has none");
        let expected = format!("`{key}`");
        return Err(context.error(format!("camera.{other_key}"), problem, expected));
    }
    let expected = match table.kind {
        CameraKind::Perspective => "an angle above 0 and below 180 degrees",
        CameraKind::Orthographic => "the height of what is seen, above 0",
    };
    let Some(value) = wanted else {
        return Err(context.error("camera", format!("missing key `{key}`"), expected));
    };
    match table.kind {
        CameraKind::Perspective if value > 0.0 && value < 180.0 => Ok(Projection::Perspective {
            fov_y: value.to_radians(),
        }),
        CameraKind::Orthographic if value > 0.0 => Ok(Projection::Orthographic { height: value }),
        _ => Err(context.error(format!("camera.{key}"), format!("is {value}"), expected)),
    }
}

/// A camera with the eye and the frame of `table`.
fn placed(context: &Context, table: &CameraTable) -> Result<Camera, InputError> {
    match (table.eye, table.target, table.matrix) {
        (Some(eye), Some(target), None) => {
            let up = table.up.map_or(DVec3::Y, DVec3::from_array);
            let (from, to) = (DVec3::from_array(eye), DVec3::from_array(target));
            Camera::look_at(from, to, up, 1.0).ok_or_else(|| {
                context.error(
                    "camera.target",
                    format!("is the eye, {eye:?}"),
                    "a point in front of the eye",
                )
            })
        }
        (None, None, Some(matrix)) if table.up.is_none() => of_matrix(&matrix).ok_or_else(|| {
            context.error(
                "camera.matrix",
                "is not a rotation and a translation (a uniform scale is allowed)",
                "a camera-to-world matrix, row by row, with the last row [0, 0, 0, 1]",
            )
        }),
        _ => Err(context.error(
            "camera",
            "its position is given in parts or twice",
            "`eye` and `target` (and `up`), or `matrix`",
        )),
    }
}

/// A camera from camera-to-world; `None` when that shears, mirrors or projects.
fn of_matrix(rows: &[[f64; 4]; 4]) -> Option<Camera> {
    let to_world = affine(rows)?;
    let m = to_world.matrix3;
    let scale = m.determinant().cbrt();
    let rotation = m * (1.0 / scale);
    let off = rotation.transpose() * rotation - DMat3::IDENTITY;
    let is_rotation = scale > 0.0 && off.to_cols_array().iter().all(|x| x.abs() < 1e-4);
    let camera = Camera::look_at(DVec3::ZERO, -rotation.z_axis, rotation.y_axis, 1.0)?;
    is_rotation.then_some(Camera {
        eye: to_world.translation,
        ..camera
    })
}
