//! Emission that varies over a primitive, and the grid by which points on it are chosen in
//! proportion to it.

use super::area_map::{square_to_disk, square_to_triangle};
use super::{is_lit, luminance};
use crate::accel::{Primitive, PrimitiveGeometry, texture_coordinates};
use crate::scene::alias_table::AliasTable;
use crate::scene::texture::interpolate_uv;
use crate::scene::{Scene, ShapeId, Texture, TextureUse, lookup};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// The texture of a light's emission and a grid over the unit square that the light's points come
/// from: a cell is chosen in proportion to the mean luminance there, and a point in it uniformly.
#[derive(Debug, Clone, PartialEq)]
pub struct EmissionMap {
    /// The shape whose emission it is.
    pub shape: ShapeId,
    /// Factor on the radiance.
    pub texture: TextureUse,
    /// Texture coordinates at the primitive's points a, a + u and a + v.
    pub uvs: [[f32; 2]; 3],
    /// Cells along each axis of the unit square.
    pub grid: [u32; 2],
    /// How a cell is chosen.
    pub table: AliasTable,
    /// Number of the first cell among those of all lights.
    pub first_cell: u32,
    /// Mean of the texture over the primitive.
    pub mean: DVec3,
}

/// Most cells along an axis.
const MAX_SIDE: f64 = 512.0;
/// Most cells of all lights together, 16 MiB of them; each light has one at least.
const MAX_CELLS: f64 = 1_048_576.0;
/// Most points along an axis at which a cell's texture is looked up.
const MAX_LOOKUPS: f64 = 16.0;
/// Part of the samples that goes to all cells alike where lookups in a cell can miss what shines in
/// it.
const UNIFORM_PART: f64 = 1.0 / 32.0;
/// What a texture that is not black is taken for at least.
const LEAST: DVec3 = DVec3::splat(1e-12);

/// The texture of a primitive's emission, before it is known how finely it is sampled.
struct Textured<'a> {
    geometry: &'a PrimitiveGeometry,
    texture: &'a Texture,
    used: TextureUse,
    shape: ShapeId,
    uvs: [DVec2; 3],
    /// Texels along the axes of the unit square.
    texels: DVec2,
}

impl<'a> Textured<'a> {
    fn new(scene: &'a Scene, primitive: &'a Primitive) -> Option<Self> {
        let used = scene.shapes[primitive.shape.index()].emission?.texture?;
        let uvs = texture_coordinates(scene, primitive, used.second_uvs)?;
        let texture = &scene.textures[used.texture.index()];
        let size = DVec2::new(texture.width.into(), texture.height.into());
        let on_image = |d: DVec2| (used.transform.matrix2 * d * size).length();
        let (s, t) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        let texels = match primitive.geometry {
            PrimitiveGeometry::Triangle { .. } => {
                let across = 0.5 * on_image(s - t);
                DVec2::new(on_image(s).max(across), on_image(t).max(across))
            }
            PrimitiveGeometry::Disk { .. } => 2.0 * DVec2::new(on_image(s), on_image(t)),
            _ => DVec2::new(on_image(s), on_image(t)),
        };
        Some(Self {
            geometry: &primitive.geometry,
            texture,
            used,
            shape: primitive.shape,
            uvs,
            texels,
        })
    }

    /// A cell per texel, as far as there may be so many.
    fn wanted_cells(&self) -> DVec2 {
        // Rounding does not make a column of a texel's border.
        (self.texels - 1e-6)
            .ceil()
            .clamp(DVec2::ONE, DVec2::splat(MAX_SIDE))
    }

    /// The texture's value where the unit square has the point `u`.
    fn value(&self, u: DVec2) -> DVec3 {
        let st = match self.geometry {
            PrimitiveGeometry::Triangle { .. } => square_to_triangle(u),
            PrimitiveGeometry::Disk { .. } => square_to_disk(u),
            _ => u,
        };
        let uv = interpolate_uv(&self.uvs, st);
        lookup::value(self.texture, &self.used, uv).truncate()
    }

    /// With so many cells; `None` where it is dark all over.
    fn map(&self, grid: DVec2) -> Option<EmissionMap> {
        if self.is_dark() {
            return None;
        }
        let [columns, rows] = [grid.x as u32, grid.y as u32];
        let lookups = (2.0 * self.texels / grid).ceil();
        let lookups = lookups.clamp(DVec2::splat(2.0), DVec2::splat(MAX_LOOKUPS));
        let means: Vec<DVec3> = (0..rows * columns)
            .into_par_iter()
            .map(|cell| {
                let corner = DVec2::new((cell % columns).into(), (cell / columns).into());
                self.cell_mean(corner, grid, lookups)
            })
            .collect();
        let mean = means.iter().sum::<DVec3>() / means.len() as f64;
        let mean = mean.max(LEAST);
        let everywhere = if self.has_cell_per_texel(grid) {
            0.0
        } else {
            UNIFORM_PART * luminance(mean)
        };
        let weights: Vec<f64> = means.iter().map(|m| luminance(*m) + everywhere).collect();
        Some(EmissionMap {
            shape: self.shape,
            texture: self.used,
            uvs: self.uvs.map(|uv| uv.as_vec2().to_array()),
            grid: [columns, rows],
            table: AliasTable::new(&weights)?,
            first_cell: 0,
            mean,
        })
    }

    /// Whether every cell is a texel: then lookups in its quarters find all that shines in it.
    fn has_cell_per_texel(&self, grid: DVec2) -> bool {
        let transform = &self.used.transform;
        let m = transform.matrix2;
        let straight = m.x_axis.y == 0.0 && m.y_axis.x == 0.0;
        let start = transform.translation * self.size();
        let rectangle = matches!(self.geometry, PrimitiveGeometry::Rectangle { .. });
        rectangle && straight && self.texels == grid && start == start.round()
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.texture.width.into(), self.texture.height.into())
    }

    /// Whether all texels that the primitive can show are black: those of the box around its
    /// corners on the image.
    fn is_dark(&self) -> bool {
        let [a, b, c] = self.uvs;
        let (s, t) = (b - a, c - a);
        let corners = match self.geometry {
            PrimitiveGeometry::Disk { .. } => [a + s + t, a + s - t, a - s + t, a - s - t],
            PrimitiveGeometry::Triangle { .. } => [a, b, c, a],
            _ => [a, b, c, b + t],
        };
        let on_image = corners.map(|uv| self.used.transform.transform_point2(uv) * self.size());
        let low = on_image.into_iter().fold(on_image[0], DVec2::min).floor() - 1.0;
        let high = on_image.into_iter().fold(on_image[0], DVec2::max).ceil() + 1.0;
        // Beyond its own size an image shows itself again.
        let count = (high - low).min(2.0 * self.size());
        let texel = |x: f64, y: f64| {
            let wrapped = |x: f64, side: u32, axis: usize| {
                let on_image =
                    lookup::wrap_coordinate((x + 0.5) / f64::from(side), self.used.wrap[axis]);
                ((on_image * f64::from(side)) as u32).min(side - 1)
            };
            let column = wrapped(low.x + x, self.texture.width, 0);
            let row = wrapped(low.y + y, self.texture.height, 1);
            self.texture.texel(column, row).truncate()
        };
        let rows = 0..count.y as u32;
        rows.into_par_iter().all(|y| {
            let mut row = 0..count.x as u32;
            row.all(|x| !is_lit(texel(x.into(), y.into())))
        })
    }

    fn cell_mean(&self, corner: DVec2, grid: DVec2, lookups: DVec2) -> DVec3 {
        let (columns, rows) = (lookups.x as u32, lookups.y as u32);
        let mut sum = DVec3::ZERO;
        for y in 0..rows {
            for x in 0..columns {
                let within = (DVec2::new(x.into(), y.into()) + 0.5) / lookups;
                sum += self.value((corner + within) / grid);
            }
        }
        sum / (lookups.x * lookups.y)
    }
}

/// The emission of one primitive.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Varies {
    /// No texture varies it.
    Not,
    /// Its texture is black there.
    Dark,
    /// The texture, with its grid.
    Textured(Box<EmissionMap>),
}

/// How the emission of each of `primitives` varies.
pub(super) fn of_primitives<'a>(
    scene: &'a Scene,
    primitives: impl Iterator<Item = &'a Primitive>,
) -> Vec<Varies> {
    let textured: Vec<_> = primitives.map(|p| Textured::new(scene, p)).collect();
    let wanted = textured.iter().flatten().map(Textured::wanted_cells);
    let wanted: f64 = wanted.map(|cells| cells.x * cells.y).sum();
    let shrink = (MAX_CELLS / wanted.max(MAX_CELLS)).sqrt();
    let one = |textured: Option<Textured<'_>>| {
        let Some(textured) = textured else {
            return Varies::Not;
        };
        let grid = (shrink * textured.wanted_cells()).floor().max(DVec2::ONE);
        match textured.map(grid) {
            None => Varies::Dark,
            Some(map) => Varies::Textured(Box::new(map)),
        }
    };
    textured.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::environment::Interpolation;
    use crate::scene::texture::rectangle_uv;
    use crate::scene::{Texels, TextureId, Wrap};
    use glam::DAffine2;

    fn textured<'a>(
        geometry: &'a PrimitiveGeometry,
        texture: &'a Texture,
        uvs: [DVec2; 3],
    ) -> Textured<'a> {
        let (s, t) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        let size = DVec2::new(texture.width.into(), texture.height.into());
        Textured {
            geometry,
            texture,
            used: TextureUse {
                texture: TextureId(0),
                transform: DAffine2::IDENTITY,
                wrap: [Wrap::Clamp; 2],
                interpolation: Interpolation::Nearest,
                second_uvs: false,
            },
            shape: ShapeId(0),
            uvs,
            texels: DVec2::new((s * size).length(), (t * size).length()),
        }
    }

    /// One row of grey texels.
    fn row(values: &[u8]) -> Texture {
        Texture {
            source: String::new(),
            width: values.len() as u32,
            height: 1,
            texels: Texels::Bytes(values.iter().map(|&v| [v, v, v, 255]).collect()),
        }
    }

    const UNIT: (DVec3, DVec3, DVec3) = (DVec3::ZERO, DVec3::X, DVec3::Y);

    #[test]
    fn a_rectangle_has_a_cell_per_texel_in_proportion_to_it() {
        let (a, u, v) = UNIT;
        let rectangle = PrimitiveGeometry::Rectangle { a, u, v };
        let texture = row(&[0, 51, 204, 0]);
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y].map(rectangle_uv);
        let light = textured(&rectangle, &texture, corners);
        let map = light.map(light.wanted_cells()).unwrap();
        assert_eq!(map.grid, [4, 1]);
        for (p, expected) in map.table.probability.iter().zip([0.0, 0.2, 0.8, 0.0]) {
            assert!((p - expected).abs() < 1e-8, "{p}, not {expected}");
        }
        assert!(
            (map.mean - 0.25).abs().max_element() < 1e-12,
            "{}",
            map.mean
        );
    }

    /// All cells of a triangle may be chosen; one that shows only black texels is no light, one
    /// that shows the edge of another is.
    #[test]
    fn a_triangle_is_dark_where_its_part_of_the_image_is() {
        let (a, u, v) = UNIT;
        let triangle = PrimitiveGeometry::Triangle { a, u, v };
        let texture = row(&[0, 0, 0, 0, 0, 0, 0, 255]);
        let up_to = |x: f64| [DVec2::ZERO, DVec2::new(x, 0.0), DVec2::new(0.0, 1.0)];
        let dark = textured(&triangle, &texture, up_to(0.5));
        assert_eq!(dark.map(dark.wanted_cells()), None);
        let lit = textured(&triangle, &texture, up_to(0.876));
        let map = lit.map(lit.wanted_cells()).unwrap();
        assert!(map.table.probability.iter().all(|&p| p > 0.0));
        assert!(map.mean.min_element() > 0.0);
    }

    /// An image of 16,384 texels per cell, one of which shines, between two lookups.
    #[test]
    fn what_lookups_miss_can_be_chosen() {
        let (a, u, v) = UNIT;
        let rectangle = PrimitiveGeometry::Rectangle { a, u, v };
        let mut values = vec![0; 16_384];
        values[5] = 255;
        let texture = row(&values);
        let light = textured(&rectangle, &texture, [DVec2::ZERO, DVec2::X, DVec2::Y]);
        let map = light.map(DVec2::ONE).unwrap();
        assert!(map.mean.min_element() > 0.0);
        let map = light.map(DVec2::new(64.0, 1.0)).unwrap();
        assert!(map.table.probability.iter().all(|&p| p > 0.0));
    }
}
