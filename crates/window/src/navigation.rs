//! Moving through a scene.
//!
//! A [`CameraController`] holds a camera as a scene file does, by eye, target and up: what is saved
//! is what is seen, bit for bit.

use direkt::scene::{Camera, Lens, Projection};
use glam::{DMat3, DVec3};

/// Smallest angle between the viewing direction and the axis that the camera turns about, in
/// radians.
const POLE: f64 = 0.02;

/// A camera that looks at a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraController {
    /// Where the camera stands.
    pub eye: DVec3,
    /// What it looks at, and turns about.
    pub target: DVec3,
    /// The axis that it turns about: a unit vector.
    pub up: DVec3,
    /// Field of view or height.
    pub projection: Projection,
    /// The lens.
    pub lens: Lens,
}

impl CameraController {
    /// A controller that sees what `camera` sees, with its target in the middle of what there is in
    /// `bounds`.
    pub fn of(camera: &Camera, bounds: Option<(DVec3, DVec3)>) -> Self {
        let middle = bounds.map(|(low, high)| 0.5 * (low + high));
        let depth = middle.map_or(1.0, |middle| (middle - camera.eye).dot(camera.forward));
        let size = bounds.map_or(1.0, |(low, high)| (high - low).length());
        // Behind the camera, or in it, nothing can be looked at.
        let distance = if depth > 1e-3 * size {
            depth
        } else {
            size.max(1e-9)
        };
        Self {
            eye: camera.eye,
            target: camera.eye + distance * camera.forward,
            up: upright(camera),
            projection: camera.projection,
            lens: camera.lens,
        }
    }

    /// The camera; none where eye and target coincide.
    pub fn camera(&self) -> Option<Camera> {
        let camera = Camera::look_at(self.eye, self.target, self.up, 1.0)?;
        Some(Camera {
            projection: self.projection,
            lens: self.lens,
            ..camera
        })
    }

    fn forward(&self) -> DVec3 {
        (self.target - self.eye).normalize()
    }

    fn right(&self) -> DVec3 {
        self.forward().cross(self.up).normalize()
    }

    fn distance(&self) -> f64 {
        self.eye.distance(self.target)
    }

    /// Turns the eye about the target, by angles to the right and upwards in radians.
    pub fn orbit(&mut self, right: f64, up: f64) {
        self.eye = self.target - self.distance() * self.turned(right, -up);
    }

    /// Turns the viewing direction about the eye.
    pub fn look(&mut self, right: f64, up: f64) {
        self.target = self.eye + self.distance() * self.turned(-right, up);
    }

    /// The viewing direction, turned by angles about the axis and upwards; not beyond the poles.
    fn turned(&self, about: f64, up: f64) -> DVec3 {
        let forward = self.forward();
        let angle = forward.dot(self.up).clamp(-1.0, 1.0).acos();
        let up = angle - (angle - up).clamp(POLE, std::f64::consts::PI - POLE);
        let turned = DMat3::from_axis_angle(self.right(), up) * forward;
        DMat3::from_axis_angle(self.up, about) * turned
    }

    /// Moves eye and target along the image, by parts of its height to the right and upwards.
    pub fn pan(&mut self, right: f64, up: f64) {
        let height = match self.projection {
            Projection::Perspective { fov_y } => 2.0 * (0.5 * fov_y).tan() * self.distance(),
            Projection::Orthographic { height } => height,
        };
        let image_up = self.right().cross(self.forward());
        self.shift(height * (right * self.right() + up * image_up));
    }

    /// Moves the eye towards the target: its distance becomes `factor` times what it was, and so
    /// does the height of what a camera with parallel rays sees.
    pub fn dolly(&mut self, factor: f64) {
        self.eye = self.target - factor * (self.target - self.eye);
        if let Projection::Orthographic { height } = &mut self.projection {
            *height *= factor;
        }
    }

    /// Moves eye and target to the right, upwards and forwards, by parts of their distance.
    pub fn fly(&mut self, [right, up, forward]: [f64; 3]) {
        let along = right * self.right() + up * self.up + forward * self.forward();
        self.shift(self.distance() * along);
    }

    fn shift(&mut self, by: DVec3) {
        self.eye += by;
        self.target += by;
    }

    /// Looks at the box from `low` to `high` from the same side, so that it fits an image of the
    /// aspect `aspect`.
    pub fn frame(&mut self, (low, high): (DVec3, DVec3), aspect: f64) {
        let radius = (0.5 * (high - low).length()).max(1e-9);
        let forward = self.forward();
        let narrow = aspect.min(1.0);
        let distance = match &mut self.projection {
            Projection::Perspective { fov_y } => {
                let half = ((0.5 * *fov_y).tan() * narrow).atan();
                radius / half.sin()
            }
            Projection::Orthographic { height } => {
                *height = 2.0 * radius / narrow;
                2.0 * radius
            }
        };
        self.target = 0.5 * (low + high);
        self.eye = self.target - distance * forward;
    }
}

/// The axis of the scene that is up: that which the camera's own is closest to.
fn upright(camera: &Camera) -> DVec3 {
    let axes = [DVec3::Y, DVec3::Z, DVec3::X];
    let along = |axis: &DVec3| axis.dot(camera.up).abs();
    let closest = axes
        .into_iter()
        .max_by(|a, b| along(a).total_cmp(&along(b)));
    let axis = closest.unwrap_or(DVec3::Y);
    axis * axis.dot(camera.up).signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: (DVec3, DVec3) = (DVec3::NEG_ONE, DVec3::ONE);

    fn controller() -> CameraController {
        let camera = Camera::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y, 0.7);
        CameraController::of(&camera.expect("a camera"), Some(BOX))
    }

    #[test]
    fn a_rig_sees_what_its_camera_saw() {
        let eye = DVec3::new(1.0, 2.0, 4.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.7).expect("a camera");
        let seen = CameraController::of(&camera, Some(BOX))
            .camera()
            .expect("a camera");
        assert!(seen.forward.distance(camera.forward) < 1e-12);
        assert!(seen.right.distance(camera.right) < 1e-12);
        assert_eq!(seen.eye, camera.eye);
        assert_eq!(seen.projection, camera.projection);
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_stops_at_the_poles() {
        let mut controller = controller();
        controller.orbit(1.0, 0.5);
        assert!((controller.eye.length() - 4.0).abs() < 1e-12);
        assert!(
            controller.eye.y > 0.0,
            "upwards lifts the eye: {}",
            controller.eye
        );
        controller.orbit(0.0, 100.0);
        assert!(controller.camera().is_some());
        assert!(
            (controller.eye.y - 4.0 * POLE.cos()).abs() < 1e-9,
            "{}",
            controller.eye
        );
        controller.orbit(0.0, -100.0);
        assert!(
            (controller.eye.y + 4.0 * POLE.cos()).abs() < 1e-9,
            "{}",
            controller.eye
        );
    }

    #[test]
    fn looking_to_the_right_turns_to_the_right() {
        let mut controller = controller();
        controller.look(0.1, 0.0);
        assert!(controller.target.x > 0.0, "{}", controller.target);
        assert_eq!(controller.eye, DVec3::new(0.0, 0.0, 4.0));
        controller.look(0.0, 0.1);
        assert!(controller.target.y > 0.0, "{}", controller.target);
    }

    #[test]
    fn a_pan_of_the_whole_height_moves_by_what_the_image_shows() {
        let mut controller = controller();
        controller.pan(0.0, 1.0);
        let height = 2.0 * (0.35_f64).tan() * 4.0;
        assert!((controller.target.y - height).abs() < 1e-12);
        assert!((controller.eye.y - height).abs() < 1e-12);
    }

    #[test]
    fn a_framed_box_fits() {
        let mut controller = controller();
        controller.orbit(0.4, 0.3);
        controller.frame((DVec3::splat(5.0), DVec3::splat(6.0)), 0.5);
        let camera = controller.camera().expect("a camera");
        let half_height = camera.half_height();
        for corner in 0..8 {
            let bit = |i: i32| f64::from(corner >> i & 1);
            let p = DVec3::splat(5.0) + DVec3::new(bit(0), bit(1), bit(2)) - camera.eye;
            let depth = p.dot(camera.forward);
            assert!(depth > 0.0);
            assert!((p.dot(camera.up) / depth / half_height).abs() <= 1.0);
            assert!((p.dot(camera.right) / depth / (0.5 * half_height)).abs() <= 1.0);
        }
    }
}
