//! Camera, film and pixel filter.

use super::{Check, Outcome, is_rotation};
use crate::scene::filter::FilterKind;
use crate::scene::{Camera, FilmSize, Lens, PixelFilter, Projection};
use glam::DMat3;
use std::f64::consts::PI;

impl Check<'_> {
    pub(super) fn film(&self, film: FilmSize) -> Outcome {
        for (side, key) in [(film.width, "width"), (film.height, "height")] {
            self.require(
                (1..=FilmSize::MAX_SIDE).contains(&side),
                || format!("film.{key}"),
                || format!("is {side}"),
                "1 to 32768 pixels",
            )?;
        }
        Ok(())
    }

    pub(super) fn camera(&self, camera: &Camera) -> Outcome {
        match camera.projection {
            Projection::Perspective { fov_y } => self.require(
                fov_y > 0.0 && fov_y < PI,
                || "camera.fov".to_owned(),
                || format!("is {}", fov_y.to_degrees()),
                "an angle above 0 and below 180 degrees",
            )?,
            Projection::Orthographic { height } => self.require(
                height > 0.0 && height.is_finite(),
                || "camera.height".to_owned(),
                || format!("is {height}"),
                "the height of what is seen, above 0",
            )?,
        }
        let Lens {
            radius,
            focus_distance,
        } = camera.lens;
        self.require(
            radius >= 0.0 && radius.is_finite(),
            || "camera.lens_radius".to_owned(),
            || format!("is {radius}"),
            "a length, not negative; 0 is a pinhole",
        )?;
        self.require(
            focus_distance > 0.0 && focus_distance.is_finite(),
            || "camera.focus_distance".to_owned(),
            || format!("is {focus_distance}"),
            "the distance of the plane that is sharp, above 0",
        )?;
        let frame = DMat3::from_cols(camera.right, camera.up, -camera.forward);
        self.require(
            camera.eye.is_finite() && is_rotation(frame),
            || "camera".to_owned(),
            || "its frame is not orthonormal and finite".to_owned(),
            "right × up = −forward, as Camera::look_at makes it",
        )
    }

    pub(super) fn filter(&self, filter: &PixelFilter) -> Outcome {
        let PixelFilter { radius, stddev, .. } = *filter;
        self.require(
            radius > 0.0 && radius <= f64::from(FilmSize::MAX_SIDE),
            || "film.filter_radius".to_owned(),
            || format!("is {radius}"),
            "pixels, above 0 and up to 32768",
        )?;
        self.require(
            filter.kind != FilterKind::Gaussian || (1e-3 * radius..=1e3 * radius).contains(&stddev),
            || "film.filter_stddev".to_owned(),
            || format!("is {stddev}, of a filter of radius {radius}"),
            "pixels, from a thousandth of the radius to a thousand times it",
        )
    }
}
