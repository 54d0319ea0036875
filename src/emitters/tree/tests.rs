//! Trees over random lights: their shape, and that bounds are bounds.

use super::*;
use crate::accel::PrimitiveGeometry;
use crate::reference::core::rng::{pcg4d, to_unit};
use crate::reference::light::tree::pdf_tree_light;
use crate::scene::{Light, PointLight, SpotLight};
use glam::DVec3;

/// Random numbers of [0, 1), one after the other.
struct Random {
    state: [u32; 4],
}

impl Random {
    fn new(seed: u32) -> Self {
        Self {
            state: [seed, 1, 2, 3],
        }
    }

    fn unit(&mut self) -> f64 {
        self.state = pcg4d(self.state);
        to_unit(self.state[0])
    }

    fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
        )
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.point();
            if p.length() > 0.1 && p.length() < 1.0 {
                return p.normalize();
            }
        }
    }
}

/// A light of any kind.
fn light(random: &mut Random, index: u32) -> TreeLight {
    let size = 10_f64.powf(random.range(-4.0, -0.5));
    let (a, u, v) = (
        random.point(),
        size * random.direction(),
        size * random.direction(),
    );
    let two_sided = random.unit() < 0.3;
    let geometry = match (random.unit() * 6.0) as u32 {
        0 => PrimitiveGeometry::Triangle { a, u, v },
        1 => PrimitiveGeometry::Rectangle { a, u, v },
        2 => PrimitiveGeometry::Disk { a, u, v },
        3 if random.unit() < 0.5 => PrimitiveGeometry::Ellipsoid {
            center: a,
            radii: size * DVec3::new(1.0, 0.1 + random.unit(), 0.1 + random.unit()),
            rodrigues: 0.5 * random.direction(),
        },
        3 => PrimitiveGeometry::Sphere {
            center: a,
            radius: size,
        },
        4 => {
            let light = Light::Point(PointLight {
                position: a,
                intensity: DVec3::splat(random.unit() + 1e-6),
            });
            return TreeLight::delta(index, &light).unwrap();
        }
        _ => {
            let outer_angle = random.range(0.01, 1.5);
            let light = Light::Spot(SpotLight {
                position: a,
                direction: random.direction(),
                intensity: DVec3::splat(random.unit() + 1e-6),
                inner_angle: outer_angle * random.unit(),
                outer_angle,
            });
            return TreeLight::delta(index, &light).unwrap();
        }
    };
    TreeLight::area(index, &geometry, random.unit() + 1e-6, two_sided)
}

fn lights(count: u32, seed: u32) -> Vec<TreeLight> {
    let mut random = Random::new(seed);
    (0..count).map(|i| light(&mut random, i)).collect()
}

/// The light at the end of each light's trail.
fn ends(tree: &LightTree) -> Vec<u32> {
    let trails = tree.trails.iter();
    let ends = trails.map(|&trail| {
        let (mut reference, mut rest) = (0, trail);
        while reference & TREE_LEAF == 0 {
            reference = tree.nodes[reference as usize][2][2 + (rest & 1) as usize];
            rest >>= 1;
        }
        reference & !TREE_LEAF
    });
    ends.collect()
}

#[test]
fn every_trail_ends_at_its_light() {
    for (count, seed) in [(2, 1), (3, 2), (17, 3), (1000, 4), (20_000, 5)] {
        let tree = LightTree::new(&lights(count, seed), vec![], count as usize).unwrap();
        assert_eq!(tree.nodes.len(), count as usize - 1);
        assert_eq!(ends(&tree), (0..count).collect::<Vec<_>>());
        let sum: f64 = (0..count as usize).map(|i| tree.mean_probability(i)).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
    assert_eq!(LightTree::new(&lights(1, 1), vec![1, 2], 3), None);
}

/// Lights at one point, on a line, and each twice as far as the one before, of which planes alone
/// would make a chain.
#[test]
fn trees_are_never_deeper_than_a_trail() {
    let at = |index: u32, position: DVec3| {
        let light = Light::Point(PointLight {
            position,
            intensity: DVec3::ONE,
        });
        TreeLight::delta(index, &light).unwrap()
    };
    let place: [fn(u32) -> DVec3; 3] = [
        |_| DVec3::ONE,
        |i| f64::from(i) * DVec3::X,
        |i| DVec3::new(0.0, 0.5, 1.0) * f64::from(i % 100).exp2(),
    ];
    for place in place {
        let lights: Vec<_> = (0..5000).map(|i| at(i, place(i))).collect();
        let tree = LightTree::new(&lights, vec![], lights.len()).unwrap();
        assert_eq!(ends(&tree), (0..5000).collect::<Vec<_>>());
    }
}

/// A point, a normal, and a point of a light from which light arrives there; `None` where none
/// does.
fn connection(random: &mut Random, light: &TreeLight) -> Option<(DVec3, DVec3)> {
    let bounds = &light.bounds;
    let on_light = light.some_point([random.unit(), random.unit()]);
    let spread = bounds.normals.angle;
    let x = match (random.unit() * 4.0) as u32 {
        // Within the light's box, close by, grazing, and anywhere.
        0 => bounds.low + (bounds.high - bounds.low) * random.unit(),
        1 => on_light + 10_f64.powf(random.range(-5.0, -1.0)) * random.direction(),
        2 => on_light + bounds.normals.axis.any_orthonormal_vector() * random.unit(),
        _ => random.point(),
    };
    // As the shader has them.
    let x = x.as_vec3().as_dvec3();
    let to = (on_light - x).try_normalize()?;
    let normal = match (random.unit() * 2.0) as u32 {
        // The light at the very horizon.
        0 => (to.any_orthonormal_vector() + 1e-6 * to).normalize(),
        _ => random.direction(),
    };
    let cos = bounds.normals.axis.dot(-to);
    let angle = if bounds.two_sided { cos.abs() } else { cos }
        .clamp(-1.0, 1.0)
        .acos();
    let whole = spread >= std::f64::consts::PI;
    let shines = whole || angle <= spread + bounds.emission;
    (shines && normal.dot(to) > 0.0).then_some((x, normal))
}

/// No light that can contribute is left out, however rounding falls (10⁵ configurations).
#[test]
fn lights_that_can_contribute_have_a_probability() {
    let mut random = Random::new(77);
    let mut connected = 0;
    for seed in 0..100 {
        let lights = lights(50, 1000 + seed);
        let tree = LightTree::new(&lights, vec![], lights.len()).unwrap();
        for _ in 0..100 {
            for light in lights.iter().take(25) {
                let Some((x, normal)) = connection(&mut random, light) else {
                    continue;
                };
                connected += 1;
                let trail = tree.trails[light.index as usize];
                let p = pdf_tree_light(&tree, trail, x, normal).0;
                assert!(p > 0.0, "{light:?} from {x}, normal {normal}");
            }
        }
    }
    assert!(connected >= 100_000, "{connected}");
}

/// A lamp that looks away, one below the horizon, and a spot that points elsewhere.
#[test]
fn lights_that_cannot_contribute_have_none() {
    let lamp = |index: u32, a: DVec3, normal: DVec3| {
        let (u, v) = normal.any_orthonormal_pair();
        let (u, v) = (0.01 * u, 0.01 * v);
        let (u, v) = if u.cross(v).dot(normal) > 0.0 {
            (u, v)
        } else {
            (v, u)
        };
        TreeLight::area(index, &PrimitiveGeometry::Rectangle { a, u, v }, 1.0, false)
    };
    let spot = Light::Spot(SpotLight {
        position: DVec3::new(0.5, 0.0, 0.5),
        direction: DVec3::X,
        intensity: DVec3::ONE,
        inner_angle: 0.1,
        outer_angle: 0.2,
    });
    let lights = [
        lamp(0, DVec3::new(0.0, 0.0, 0.5), DVec3::Z),
        lamp(1, DVec3::new(0.3, 0.0, -0.5), DVec3::Z),
        TreeLight::delta(2, &spot).unwrap(),
        lamp(3, DVec3::new(-0.3, 0.0, 0.5), DVec3::NEG_Z),
    ];
    let tree = LightTree::new(&lights, vec![], 4).unwrap();
    let p = |i: usize| pdf_tree_light(&tree, tree.trails[i], DVec3::ZERO, DVec3::Z).0;
    for (i, expected) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        assert!((p(i) - expected).abs() < 1e-12, "light {i}: {}", p(i));
    }
}
