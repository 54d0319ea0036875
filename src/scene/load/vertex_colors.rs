//! Vertex colours: factors on the reflectance and the opacity of what a mesh's material says.

use super::texture::srgb;
use crate::scene::{Bsdf, Geometry, Mesh, Scene};
use glam::Vec4;

/// Brings colours into [0, 1] and counts those that were not.
#[derive(Debug, Default)]
pub(super) struct Clamped {
    count: usize,
    largest: f64,
}

impl Clamped {
    /// The colour as factors; `None` where it is not finite.
    pub(super) fn color(&mut self, color: [f64; 4]) -> Option<Vec4> {
        if !color.iter().all(|c| c.is_finite()) {
            return None;
        }
        if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
            self.count += 1;
            self.largest = color.iter().copied().fold(self.largest, f64::max);
        }
        Some(Vec4::from_array(color.map(|c| c.clamp(0.0, 1.0) as f32)))
    }

    /// What is to be said of those.
    pub(super) fn sentence(&self) -> Option<String> {
        (self.count > 0).then(|| {
            let colors = if self.count == 1 {
                "1 vertex colour is".to_owned()
            } else {
                format!("{} vertex colours are", self.count)
            };
            let largest = self.largest as f32;
            format!("{colors} not from 0 to 1 (the largest channel is {largest}); such channels are taken as the nearest of these")
        })
    }
}

/// The colours, unless all of them are white and opaque, which changes nothing.
pub(super) fn unless_white(colors: Vec<Vec4>) -> Vec<Vec4> {
    if colors.iter().all(|c| *c == Vec4::ONE) {
        Vec::new()
    } else {
        colors
    }
}

/// Decodes colours that are encoded as sRGB; alpha is linear.
pub(super) fn decode_srgb(colors: &mut [Vec4]) {
    for color in colors {
        let linear = color.to_array().map(|c| srgb(f64::from(c)) as f32);
        *color = Vec4::from_array(linear).with_w(color.w);
    }
}

/// Makes the colours of `mesh` opaque. Returns whether some were not.
pub(super) fn drop_alpha(mesh: &mut Mesh) -> bool {
    let translucent = mesh.colors.iter().any(|c| c.w < 1.0);
    for color in &mut mesh.colors {
        color.w = 1.0;
    }
    mesh.colors = unless_white(std::mem::take(&mut mesh.colors));
    translucent
}

fn colored(scene: &mut Scene) -> impl Iterator<Item = (&str, usize, &mut Mesh)> {
    scene.shapes.iter_mut().filter_map(|shape| {
        let material = shape.material.index();
        match &mut shape.geometry {
            Geometry::Mesh(mesh) if !mesh.colors.is_empty() => {
                Some((shape.name.as_str(), material, mesh))
            }
            _ => None,
        }
    })
}

/// Drops colours where they would be a factor on nothing: a metal that is given by its index of
/// refraction has no reflectance beside it.
pub(super) fn drop_on_metals(scene: &mut Scene) {
    let is_metal = |bsdf: &Bsdf| matches!(bsdf, Bsdf::Metal { .. });
    let metals: Vec<bool> = scene.materials.iter().map(|m| is_metal(&m.bsdf)).collect();
    let mut warnings = Vec::new();
    for (name, material, mesh) in colored(scene).filter(|(_, material, _)| metals[*material]) {
        let white = |c: &Vec4| Vec4::ONE.with_w(c.w);
        if mesh.colors.iter().any(|c| *c != white(c)) {
            warnings.push((name.to_owned(), material));
        }
        let colors = mesh.colors.iter().map(white).collect();
        mesh.colors = unless_white(colors);
    }
    for (name, material) in warnings {
        let material = &scene.materials[material].name;
        scene.warnings.push(format!(
            "{name}: vertex colours are ignored: material `{material}` is a metal given by its index of refraction"
        ));
    }
}

/// Opacities without what makes no difference: textures and vertex colours of one alpha, and masks
/// that stop all rays or none.
pub(super) fn fold_opacity(scene: &mut Scene) {
    let mut ranges = vec![None; scene.materials.len()];
    for shape in &scene.shapes {
        let alphas: &[Vec4] = match &shape.geometry {
            Geometry::Mesh(mesh) if !mesh.colors.is_empty() => &mesh.colors,
            _ => &[Vec4::ONE],
        };
        let range = &mut ranges[shape.material.index()];
        for alpha in alphas.iter().map(|c| f64::from(c.w)) {
            let [low, high] = range.unwrap_or([alpha; 2]);
            *range = Some([alpha.min(low), alpha.max(high)]);
        }
    }
    let mut folded = vec![false; scene.materials.len()];
    for (index, material) in scene.materials.iter_mut().enumerate() {
        let opacity = &mut material.opacity;
        let texels = opacity.texture.map_or([1.0; 2], |t| {
            scene.textures[t.texture.index()].alpha_range()
        });
        let [low, high] = ranges[index].unwrap_or([1.0; 2]);
        let alphas = [low * texels[0], high * texels[1]];
        folded[index] = opacity.at(alphas[0]) >= opacity.at(alphas[1]);
        *opacity = opacity.folded(alphas);
    }
    for (_, material, mesh) in colored(scene) {
        if folded[material] {
            drop_alpha(mesh);
        }
    }
}
