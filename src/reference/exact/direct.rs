//! Direct lighting of one receiver with any BSDF by one unoccluded area light of constant radiance.
//!
//! ```text
//!     L_o = ∫_A L f_r cosθ cosθ'/d² dA = ∫_Ω L f_r cosθ dω
//! ```
//!
//! The horizon is a border of the domain of integration, and the domain is cut where the integrand
//! may peak, so that lights partly below the horizon, near lights and narrow lobes converge as
//! well.

use super::cubature::{Estimate, Tolerance};
use super::domain::View;
use glam::DVec3;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Where it is.
    pub point: DVec3,
    /// Unit normal; light comes from this side only.
    pub normal: DVec3,
}

/// What emits.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A convex planar polygon, its normal by the right-hand rule.
    Polygon(Vec<DVec3>),
    /// A disk.
    Disk {
        /// Its centre.
        centre: DVec3,
        /// Unit normal.
        normal: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A sphere, its normals outwards.
    Sphere {
        /// Its centre.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
}

impl Shape {
    /// The parallelogram with this corner and these edges, its normal along their cross product.
    pub fn parallelogram(corner: DVec3, edges: [DVec3; 2]) -> Self {
        let [a, b] = edges;
        Self::Polygon(vec![corner, corner + a, corner + a + b, corner + b])
    }
}

/// A light of constant radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaLight {
    /// What emits.
    pub shape: Shape,
    /// Emitted radiance.
    pub radiance: DVec3,
    /// Whether both sides emit, or only that of the normal.
    pub two_sided: bool,
}

/// Radiance that `receiver` reflects towards unit direction `wo`, lit by `light` without occlusion.
///
/// `bsdf` is f_r as a function of the unit direction towards the light, in 1/sr and without the
/// cosine. `wo` serves only to find the lobe: the domain is cut in its mirror direction. The
/// result's `error` tells whether the tolerance was met.
pub fn direct_lighting(
    receiver: &Receiver,
    wo: DVec3,
    bsdf: impl Fn(DVec3) -> DVec3,
    light: &AreaLight,
    tolerance: Tolerance,
) -> Estimate {
    let n = receiver.normal;
    let mirror = n * (2.0 * n.dot(wo)) - wo;
    let view = View {
        normal: n,
        mirror,
        tolerance,
        two_sided: light.two_sided,
    };
    let unit = match &light.shape {
        Shape::Polygon(vertices) => {
            let local: Vec<DVec3> = vertices.iter().map(|v| v - receiver.point).collect();
            view.polygon(&bsdf, &local)
        }
        Shape::Disk {
            centre,
            normal,
            radius,
        } => view.disk(&bsdf, centre - receiver.point, *normal, *radius),
        Shape::Sphere { centre, radius } => view.sphere(&bsdf, centre - receiver.point, *radius),
    };
    Estimate {
        value: unit.value * light.radiance,
        error: unit.error * light.radiance.abs().max_element(),
    }
}

/// The configuration factor of `shape` by cubature to a relative `tolerance`, for closed forms to
/// be held against, and the bound of its error.
#[cfg(test)]
pub(super) fn factor_by_cubature(receiver: &Receiver, shape: Shape, tolerance: f64) -> (f64, f64) {
    let light = AreaLight {
        shape,
        radiance: DVec3::ONE,
        // Rounding may put a receiver on a sphere inside, where its closed form counts it as such.
        two_sided: true,
    };
    let white = |_| DVec3::splat(std::f64::consts::FRAC_1_PI);
    let tolerance = Tolerance::relative(tolerance);
    let integral = direct_lighting(receiver, receiver.normal, white, &light, tolerance);
    (integral.value.x, integral.error)
}

#[cfg(test)]
mod tests {
    use super::super::ggx::{Lobe, directional_albedo};
    use super::*;
    use glam::DMat3;

    fn ggx(frame: DMat3, wo: DVec3, alpha: f64) -> impl Fn(DVec3) -> DVec3 {
        let to_local = frame.transpose();
        let lobe = Lobe {
            alpha,
            f0: DVec3::new(1.0, 0.5, 0.04),
        };
        move |wi| lobe.eval(to_local * wo, to_local * wi)
    }

    fn frame(normal: DVec3) -> DMat3 {
        let (x, y) = normal.any_orthonormal_pair();
        DMat3::from_cols(x, y, normal)
    }

    #[test]
    fn a_light_all_around_gives_the_albedo() {
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        let frame = frame(normal);
        let receiver = Receiver {
            point: DVec3::new(1.0, 2.0, 3.0),
            normal,
        };
        let light = AreaLight {
            shape: Shape::Sphere {
                centre: receiver.point + DVec3::X,
                radius: 3.0,
            },
            radiance: DVec3::ONE,
            two_sided: true,
        };
        for (alpha, degrees) in [(1.0, 0.0), (0.3, 60.0), (0.01, 45.0), (0.001, 80.0_f64)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let wo = frame * DVec3::new(sin * 0.6, sin * 0.8, cos);
            let found = direct_lighting(
                &receiver,
                wo,
                ggx(frame, wo, alpha),
                &light,
                Tolerance::relative(1e-10),
            );
            let albedo = directional_albedo(alpha, cos);
            let exact = DVec3::new(1.0, 0.5, 0.04) * albedo.scale + albedo.bias;
            assert!(
                (found.value - exact).abs().max_element() < 2e-10,
                "{alpha} {degrees}: {found:?}"
            );
        }
    }

    /// The same light as polygon, as two triangles and as many cells of a grid.
    #[test]
    fn parts_of_a_light_add_up() {
        let normal = DVec3::Z;
        let receiver = Receiver {
            point: DVec3::ZERO,
            normal,
        };
        let wo = DVec3::new(0.4, 0.1, 0.6).normalize();
        for (alpha, corner, edges) in [
            (
                0.02,
                DVec3::new(-2.0, -1.0, 1.0),
                [DVec3::Y * 2.0, DVec3::X * 3.0],
            ),
            (
                0.2,
                DVec3::new(-0.5, -1.0, -0.5),
                [DVec3::Y * 2.0, DVec3::new(0.2, 0.0, 2.0)],
            ),
        ] {
            let bsdf = ggx(DMat3::IDENTITY, wo, alpha);
            let lit = |shape: Shape| {
                let light = AreaLight {
                    shape,
                    radiance: DVec3::ONE,
                    two_sided: true,
                };
                direct_lighting(&receiver, wo, &bsdf, &light, Tolerance::relative(1e-11)).value
            };
            let whole = lit(Shape::parallelogram(corner, edges));
            let [a, b] = edges;
            let triangles = lit(Shape::Polygon(vec![corner, corner + a, corner + a + b]))
                + lit(Shape::Polygon(vec![corner, corner + a + b, corner + b]));
            let mut grid = DVec3::ZERO;
            for i in 0..15 {
                let corner = corner + a * f64::from(i % 5) / 5.0 + b * f64::from(i / 5) / 3.0;
                grid += lit(Shape::parallelogram(corner, [a / 5.0, b / 3.0]));
            }
            assert!(whole.x > 1e-3);
            assert!(
                (triangles - whole).length() < 1e-10 * whole.x,
                "{whole} {triangles}"
            );
            assert!((grid - whole).length() < 1e-10 * whole.x, "{whole} {grid}");
        }
    }

    /// A disk and a sphere that cover the same cone of directions show the same radiance.
    #[test]
    fn shapes_of_equal_directions_give_equal_radiance() {
        let receiver = Receiver {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        };
        for (alpha, axis, wo) in [
            (0.05, DVec3::new(0.2, 0.3, 1.0), DVec3::new(-0.3, -0.2, 1.0)),
            (0.5, DVec3::new(1.0, 0.1, 0.2), DVec3::new(-1.0, 0.4, 0.5)),
            (
                0.001,
                DVec3::new(0.0, 1.0, 1.0),
                DVec3::new(0.01, -1.0, 1.1),
            ),
        ] {
            let (axis, wo) = (axis.normalize(), wo.normalize());
            let bsdf = ggx(DMat3::IDENTITY, wo, alpha);
            let lit = |shape: Shape| {
                let light = AreaLight {
                    shape,
                    radiance: DVec3::ONE,
                    two_sided: false,
                };
                direct_lighting(&receiver, wo, &bsdf, &light, Tolerance::relative(1e-10))
            };
            let sphere = lit(Shape::Sphere {
                centre: axis * 2.5,
                radius: 1.5,
            });
            let disk = lit(Shape::Disk {
                centre: axis * 4.0,
                normal: -axis,
                radius: 3.0,
            });
            let difference = (sphere.value - disk.value).abs().max_element();
            assert!(difference < 1e-9 * sphere.value.x, "{sphere:?} {disk:?}");
        }
    }

    #[test]
    fn one_sided_lights_are_dark_from_behind() {
        let receiver = Receiver {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        };
        let shapes = [
            Shape::parallelogram(DVec3::new(0.0, 0.0, 1.0), [DVec3::X, DVec3::Y]),
            Shape::Disk {
                centre: DVec3::Z,
                normal: DVec3::Z,
                radius: 1.0,
            },
            Shape::Sphere {
                centre: DVec3::Z * 0.1,
                radius: 1.0,
            },
        ];
        for shape in shapes {
            let lit = |two_sided| {
                let light = AreaLight {
                    shape: shape.clone(),
                    radiance: DVec3::ONE,
                    two_sided,
                };
                direct_lighting(
                    &receiver,
                    DVec3::Z,
                    |_| DVec3::ONE,
                    &light,
                    Tolerance::relative(1e-9),
                )
                .value
            };
            assert!(lit(true).x > 0.1, "{shape:?}");
            assert_eq!(lit(false), DVec3::ZERO, "{shape:?}");
        }
    }
}
