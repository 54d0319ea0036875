//! A scene from a seed: a place, what stands in it, what hides light, lights of all kinds and sizes,
//! and a camera that looks at it.

use super::random::Random;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// The scene of number `seed`, as a scene file that lies beside [`textures`](super::textures).
pub fn scene(seed: u64) -> String {
    let mut writer = Writer {
        random: Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d)),
        text: format!("# Scene {seed} of the generator `examples/random_scenes`.\n"),
        materials: 0,
    };
    writer.camera();
    writer.materials();
    writer.place();
    writer.objects();
    writer.occluders();
    writer.lights();
    writer.text
}

struct Writer {
    random: Random,
    text: String,
    /// How many there are: `m0`, `m1`, …
    materials: usize,
}

impl Writer {
    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        self.text
            .write_fmt(format_args!("{line}\n"))
            .expect("a string takes text");
    }

    /// A number from 0 to below 1.
    fn unit(&mut self) -> f64 {
        (self.random.word() >> 11) as f64 * (-53_f64).exp2()
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in its logarithm.
    fn scaled(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    fn color(&mut self) -> [f64; 3] {
        [0; 3].map(|_| self.between(0.02, 0.9))
    }

    /// A colour whose largest channel is 1, mostly near white.
    fn tint(&mut self) -> [f64; 3] {
        let rgb = [0; 3].map(|_| self.between(0.3, 1.0));
        let largest = rgb.into_iter().fold(0.0, f64::max);
        rgb.map(|x| x / largest)
    }

    fn direction(&mut self) -> [f64; 3] {
        let z = self.between(-1.0, 1.0);
        let azimuth = self.between(0.0, TAU);
        let r = (1.0 - z * z).sqrt();
        [r * azimuth.cos(), z, r * azimuth.sin()]
    }

    /// A point over the floor, not far from the middle.
    fn point(&mut self, height: f64) -> [f64; 3] {
        let (x, z) = (self.between(-1.6, 1.6), self.between(-1.6, 1.6));
        [x, self.between(0.0, height), z]
    }

    fn material(&mut self) -> String {
        format!("m{}", self.random.below(self.materials))
    }

    fn camera(&mut self) {
        let distance = self.scaled(2.5, 7.0);
        let azimuth = self.between(-0.9, 0.9);
        let height = self.scaled(0.2, 3.0);
        let eye = [distance * azimuth.sin(), height, distance * azimuth.cos()];
        let target = [
            self.between(-0.4, 0.4),
            self.between(0.1, 0.8),
            self.between(-0.4, 0.4),
        ];
        self.line(format_args!("[camera]\neye = {eye:?}\ntarget = {target:?}"));
        if self.chance(0.1) {
            let seen = self.between(1.0, 4.0);
            self.line(format_args!("type = \"orthographic\"\nheight = {seen:?}"));
        } else {
            let fov = self.between(18.0, 65.0);
            self.line(format_args!("fov = {fov:?}"));
            if self.chance(0.3) {
                let radius = self.scaled(0.003, 0.3);
                let focus = distance * self.between(0.5, 1.3);
                self.line(format_args!(
                    "lens_radius = {radius:?}\nfocus_distance = {focus:?}"
                ));
            }
        }
        let filter =
            *self
                .random
                .one_of(&["box", "box", "box", "tent", "gaussian", "blackman-harris"]);
        self.line(format_args!(
            "[film]\nwidth = 48\nheight = 48\nfilter = \"{filter}\""
        ));
    }

    fn materials(&mut self) {
        self.materials = 3 + self.random.below(3);
        for i in 0..self.materials {
            self.line(format_args!("[materials.m{i}]"));
            let color = self.color();
            let alpha = self.scaled(2e-3, 1.0);
            let metallic = self.random.below(3) as f64 / 2.0;
            // The first is never specular, so that something is lit directly.
            match if i == 0 { 0 } else { self.random.below(8) } {
                0..=2 => self.line(format_args!("type = \"lambert\"\nreflectance = {color:?}")),
                3 => self.line(format_args!(
                    "type = \"plastic\"\nreflectance = {color:?}\nalpha = {alpha:?}"
                )),
                4 => self.line(format_args!(
                    "type = \"conductor\"\nmetal = \"gold\"\nalpha = {alpha:?}"
                )),
                5 => self.line(format_args!(
                    "type = \"metallic-roughness\"\nbase_color = {color:?}\nmetallic = {metallic:?}\nroughness = {:?}",
                    alpha.sqrt()
                )),
                6 => self.line(format_args!("type = \"mirror\"\nreflectance = {color:?}")),
                _ => self.line(format_args!("type = \"dielectric\"")),
            }
            if i == 0 && self.chance(0.2) {
                self.line(format_args!(
                    "[materials.m0.textures]\ncolor = {{ file = \"holes.png\" }}"
                ));
            }
        }
        let opacity = self.between(0.1, 0.9);
        let color = self.color();
        self.line(format_args!(
            "[materials.veil]\ntype = \"lambert\"\nreflectance = {color:?}\nopacity = {opacity:?}"
        ));
        let cutoff = if self.chance(0.5) {
            "alpha_cutoff = 0.5\n"
        } else {
            ""
        };
        self.line(format_args!(
            "[materials.leaf]\ntype = \"lambert\"\nreflectance = 0.7\n{cutoff}[materials.leaf.textures]\ncolor = {{ file = \"holes.png\" }}\nopacity = {{ file = \"holes.png\" }}"
        ));
    }

    fn sphere(&mut self, material: &str, center: [f64; 3], radius: f64) {
        self.line(format_args!(
            "[[shapes]]\ntype = \"sphere\"\nmaterial = \"{material}\"\ncenter = {center:?}\nradius = {radius:?}"
        ));
    }

    /// A unit sphere scaled and moved.
    fn ellipsoid(&mut self, material: &str, center: [f64; 3], scale: [f64; 3]) {
        self.line(format_args!(
            "[[shapes]]\ntype = \"sphere\"\nmaterial = \"{material}\"\ntransform = [{{ scale = {scale:?} }}, {{ translate = {center:?} }}]"
        ));
    }

    fn disk(&mut self, material: &str, center: [f64; 3], normal: [f64; 3], radius: f64) {
        self.line(format_args!(
            "[[shapes]]\ntype = \"disk\"\nmaterial = \"{material}\"\ncenter = {center:?}\nnormal = {normal:?}\nradius = {radius:?}"
        ));
    }

    fn rectangle(&mut self, material: &str, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) {
        self.line(format_args!(
            "[[shapes]]\ntype = \"rectangle\"\nmaterial = \"{material}\"\ncorner = {corner:?}\nu = {u:?}\nv = {v:?}"
        ));
    }

    fn cuboid(&mut self, material: &str, min: [f64; 3], max: [f64; 3]) {
        self.line(format_args!(
            "[[shapes]]\ntype = \"box\"\nmaterial = \"{material}\"\nmin = {min:?}\nmax = {max:?}"
        ));
    }

    /// A floor, perhaps with walls and a ceiling.
    fn place(&mut self) {
        let reach = self.scaled(3.0, 30.0);
        self.rectangle(
            "m0",
            [-reach, 0.0, reach],
            [2.0 * reach, 0.0, 0.0],
            [0.0, 0.0, -2.0 * reach],
        );
        if self.chance(0.4) {
            let wall = self.material();
            let height = self.between(2.0, 4.0);
            self.rectangle(
                &wall,
                [-3.0, 0.0, -2.5],
                [6.0, 0.0, 0.0],
                [0.0, height, 0.0],
            );
            if self.chance(0.5) {
                self.rectangle(
                    "m0",
                    [-3.0, 0.0, 8.0],
                    [0.0, 0.0, -10.5],
                    [0.0, height, 0.0],
                );
                self.rectangle("m0", [3.0, 0.0, -2.5], [0.0, 0.0, 10.5], [0.0, height, 0.0]);
            }
            if self.chance(0.4) {
                self.rectangle(
                    "m0",
                    [-3.0, height, -2.5],
                    [6.0, 0.0, 0.0],
                    [0.0, 0.0, 10.5],
                );
            }
        }
    }

    fn objects(&mut self) {
        let many = self.chance(0.12);
        let count = if many {
            100 + self.random.below(200)
        } else {
            1 + self.random.below(7)
        };
        for _ in 0..count {
            let material = self.material();
            let size = if many { 0.06 } else { self.scaled(0.05, 0.6) };
            let [x, y, z] = self.point(if many { 1.5 } else { 0.8 });
            let center = [x, y + size, z];
            match self.random.below(5) {
                0 | 1 => self.sphere(&material, center, size),
                2 => {
                    let scale = [0; 3].map(|_| size * self.between(0.2, 1.0));
                    self.ellipsoid(&material, center, scale);
                }
                3 => {
                    let normal = self.direction();
                    self.disk(&material, center, normal, size);
                }
                _ => {
                    let min = [x - size, y, z - size];
                    let max = [x + size, y + 2.0 * size, z + size];
                    self.cuboid(&material, min, max);
                }
            }
        }
    }

    /// What light comes through in part: a wall with a slit, veils, cards with holes.
    fn occluders(&mut self) {
        if self.chance(0.2) {
            let gap = self.scaled(4e-3, 0.4);
            let at = self.between(-0.8, 0.8);
            let z = self.between(-1.0, 0.2);
            self.cuboid("m0", [-3.0, 0.0, z - 0.2], [at - 0.5 * gap, 1.2, z]);
            self.cuboid("m0", [at + 0.5 * gap, 0.0, z - 0.2], [3.0, 1.2, z]);
        }
        for material in ["veil", "leaf"] {
            if self.chance(0.2) {
                for _ in 0..1 + self.random.below(4) {
                    let [x, _, z] = self.point(1.0);
                    let [dx, _, dz] = self.direction();
                    self.rectangle(material, [x, 0.0, z], [dx, 0.0, dz], [0.0, 1.4, 0.0]);
                }
            }
        }
    }

    fn lights(&mut self) {
        if self.chance(0.06) {
            for _ in 0..60 + self.random.below(200) {
                self.area_light(0.05, 0.02);
            }
        }
        for _ in 0..self.random.few() {
            match self.random.below(9) {
                0..=4 => {
                    let size = self.scaled(1e-6, 30.0);
                    let power = self.scaled(0.5, 200.0);
                    self.area_light(size, power);
                }
                5 => {
                    let [position, intensity] = [self.over(), self.strength(1.0, 40.0)];
                    self.line(format_args!(
                        "[[lights]]\ntype = \"point\"\nposition = {position:?}\nintensity = {intensity:?}"
                    ));
                }
                6 => {
                    let [position, target] = [self.over(), self.point(0.5)];
                    let intensity = self.strength(3.0, 200.0);
                    let outer = self.between(4.0, 50.0);
                    let inner = outer * self.unit();
                    self.line(format_args!(
                        "[[lights]]\ntype = \"spot\"\nposition = {position:?}\ntarget = {target:?}\nintensity = {intensity:?}\ninner = {inner:?}\nouter = {outer:?}"
                    ));
                }
                7 => {
                    let [x, y, z] = self.direction();
                    let direction = [x, -y.abs() - 0.05, z];
                    let irradiance = self.strength(0.2, 8.0);
                    self.line(format_args!(
                        "[[lights]]\ntype = \"directional\"\ndirection = {direction:?}\nirradiance = {irradiance:?}"
                    ));
                    if self.chance(0.6) {
                        let diameter = self.scaled(0.01, 40.0);
                        self.line(format_args!("angular_diameter = {diameter:?}"));
                    }
                }
                _ => {}
            }
        }
        let environment = self.unit();
        if environment < 0.2 {
            let radiance = self.strength(0.02, 1.0);
            self.line(format_args!("[environment]\nradiance = {radiance:?}"));
        } else if environment < 0.35 {
            let (rotation, scale) = (self.between(0.0, 360.0), self.scaled(0.1, 3.0));
            self.line(format_args!(
                "[environment]\nfile = \"sky.hdr\"\nrotation = {rotation:?}\nscale = {scale:?}"
            ));
        }
        // So that no scene is black.
        self.area_light(0.3, 3.0);
    }

    /// A place for a light: over the scene, behind it or beside it.
    fn over(&mut self) -> [f64; 3] {
        let (x, z) = (self.between(-2.5, 2.5), self.between(-2.3, 2.5));
        [x, self.scaled(0.1, 3.5), z]
    }

    fn strength(&mut self, low: f64, high: f64) -> [f64; 3] {
        let strength = self.scaled(low, high);
        self.tint().map(|x| strength * x)
    }

    /// A shape about as large as `size` that emits `power`.
    fn area_light(&mut self, size: f64, power: f64) {
        let material = self.material();
        let [x, y, z] = self.over();
        let center = [x, y + size, z];
        let tint = self.tint();
        let (area, sides) = match self.random.below(4) {
            0 => {
                self.sphere(&material, center, size);
                (4.0 * PI * size * size, "")
            }
            1 => {
                let normal = self.direction();
                self.disk(&material, center, normal, size);
                (2.0 * PI * size * size, ", two_sided = true")
            }
            2 => {
                let scale = [1.0, self.between(0.1, 1.0), self.between(0.1, 1.0)];
                self.ellipsoid(&material, center, scale.map(|x| x * size));
                (4.0 * PI * size * size, "")
            }
            _ => {
                let long = self.scaled(0.05, 1.0) * size;
                let [dx, dy, dz] = self.direction();
                // Any edge across the other.
                let across = if dy.abs() < 0.9 {
                    [dz, 0.0, -dx]
                } else {
                    [0.0, dz, -dy]
                };
                let u = [dx, dy, dz].map(|x| x * size);
                self.rectangle(&material, center, u, across.map(|x| x * long));
                (2.0 * size * long, ", two_sided = true")
            }
        };
        let radiance = tint.map(|x| x * power / (PI * area));
        self.line(format_args!(
            "emission = {{ radiance = {radiance:?}{sides} }}"
        ));
    }
}
