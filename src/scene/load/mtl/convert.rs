//! From the materials of a library to direkt's; `docs/materials.md` has the table.

use super::find;
use crate::scene::environment::Interpolation;
use crate::scene::load::files::{self, Folders};
use crate::scene::load::text;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::material::DielectricLayer;
use crate::scene::{
    Bsdf, Emission, Material, MaterialTextures, NormalMap, Opacity, TextureUse, Wrap,
};
use glam::{DAffine2, DMat2, DVec2, DVec3};
use std::collections::BTreeSet;
use std::path::Path;

/// Index of refraction where a library gives none.
const DEFAULT_IOR: f64 = 1.5;
/// Diffuse reflectance where a library gives none; that of shapes without a material.
const DEFAULT_REFLECTANCE: f64 = 0.5;
/// Roughness of a material that gives its metalness alone.
const DEFAULT_ROUGHNESS: f64 = 0.5;

/// Converts the materials of the library `file`.
pub(super) struct Converter<'a> {
    pub(super) file: &'a Path,
    pub(super) folders: Folders,
    pub(super) textures: &'a mut Textures,
    /// Keywords that are not shown.
    pub(super) ignored: &'a mut BTreeSet<String>,
    pub(super) warnings: &'a mut Vec<String>,
}

/// Looks up the maps that `material` of `file` names, so that they count as the scene's files
/// whether they are shown or not.
pub(super) fn look_up_maps(material: &tobj::Material, file: &Path, folders: &Folders) {
    let known = [
        &material.ambient_texture,
        &material.diffuse_texture,
        &material.specular_texture,
        &material.normal_texture,
        &material.shininess_texture,
        &material.dissolve_texture,
    ];
    let known = known.into_iter().flatten();
    for map in known.chain(material.unknown_param.values()) {
        // What is no name of a file is not found.
        let _ = find(folders, Map::parse(map).name, file, "map");
    }
}

impl Converter<'_> {
    /// `from` as a material of direkt, and what it emits.
    pub(super) fn convert(&mut self, from: &tobj::Material) -> (Material, Option<Emission>) {
        let color = self.texture(
            from,
            "map_Kd",
            from.diffuse_texture.as_deref(),
            Meaning::Color,
        );
        let normal = self.texture(from, "norm", parameter(from, "norm"), Meaning::Vector);
        let normal = normal.map(|texture| NormalMap {
            texture,
            scale: 1.0,
        });
        let bsdf = self.bsdf(from, color.is_some());
        let through = matches!(bsdf, Bsdf::Dielectric { .. });
        let opacity = if through {
            Opacity::default()
        } else {
            self.opacity(from)
        };
        let emission = self.emission(from);
        self.note_ignored(from, through);
        let material = Material {
            name: from.name.clone(),
            bsdf,
            double_sided: true,
            textures: MaterialTextures {
                color,
                metallic_roughness: None,
                normal,
                ..MaterialTextures::default()
            },
            opacity,
        };
        (material, emission)
    }

    fn bsdf(&mut self, from: &tobj::Material, textured: bool) -> Bsdf {
        let given = from.diffuse.map(|kd| self.factor(from, "Kd", kd));
        let default = if textured { 1.0 } else { DEFAULT_REFLECTANCE };
        let reflectance = given.unwrap_or(DVec3::splat(default));
        let illumination = from.illumination_model;
        if matches!(illumination, Some(6 | 7)) {
            let transmittance = color(from, "Tf").map(|tf| self.factor(from, "Tf", tf));
            return Bsdf::Dielectric {
                ior: self.ior(from),
                transmittance: transmittance.unwrap_or(DVec3::ONE),
                thin: false,
            };
        }
        let (roughness, metallic) = (number(from, "Pr"), number(from, "Pm"));
        if roughness.is_some() || metallic.is_some() {
            let layer = DielectricLayer {
                ior: self.ior(from),
                ..DielectricLayer::default()
            };
            return Bsdf::MetallicRoughness {
                base_color: reflectance,
                metallic: metallic.unwrap_or(0.0).clamp(0.0, 1.0),
                roughness: roughness.unwrap_or(DEFAULT_ROUGHNESS).clamp(0.0, 1.0),
                layer,
            };
        }
        let specular = from.specular.map(|ks| self.factor(from, "Ks", ks));
        let specular = specular.unwrap_or(DVec3::ZERO);
        if specular == DVec3::ZERO || matches!(illumination, Some(0 | 1)) {
            return Bsdf::Lambert { reflectance };
        }
        let mirror = matches!(illumination, Some(3 | 5));
        // The Beckmann width that a Phong lobe of this exponent is like (Walter et al. 2007,
        // section 5).
        let exponent = from.shininess.unwrap_or(0.0).max(0.0);
        let alpha = if mirror {
            0.0
        } else {
            (2.0 / (exponent + 2.0)).sqrt()
        };
        let layer = DielectricLayer::default();
        Bsdf::MetallicRoughness {
            base_color: reflectance,
            metallic: 0.0,
            roughness: alpha.sqrt(),
            layer: DielectricLayer {
                specular_color: specular / layer.f0(),
                ..layer
            },
        }
    }

    fn opacity(&mut self, from: &tobj::Material) -> Opacity {
        let transparency = number(from, "Tr").map(|tr| 1.0 - tr);
        let factor = from
            .dissolve
            .or(transparency)
            .unwrap_or(1.0)
            .clamp(0.0, 1.0);
        if factor <= 0.0 {
            self.warn(from, "is invisible: d is 0, or Tr is 1");
        }
        let map = from.dissolve_texture.as_deref();
        Opacity {
            factor,
            texture: self.texture(from, "map_d", map, Meaning::Opacity),
            cutoff: None,
        }
    }

    /// The back emits as well, as both sides scatter alike.
    fn emission(&mut self, from: &tobj::Material) -> Option<Emission> {
        let texture = self.texture(from, "map_Ke", parameter(from, "map_Ke"), Meaning::Color);
        let default = if texture.is_some() { 1.0 } else { 0.0 };
        let radiance = from
            .emissive
            .map_or(DVec3::splat(default), DVec3::from_array);
        let radiance = radiance.max(DVec3::ZERO);
        (radiance.max_element() > 0.0).then_some(Emission {
            radiance,
            texture,
            two_sided: true,
        })
    }

    /// A colour as factors from 0 to 1.
    fn factor(&mut self, from: &tobj::Material, key: &str, color: [f64; 3]) -> DVec3 {
        let color = DVec3::from_array(color);
        let factor = color.clamp(DVec3::ZERO, DVec3::ONE);
        if factor != color {
            self.warn(from, &format!("has {key} {color}, taken as {factor}"));
        }
        factor
    }

    fn ior(&mut self, from: &tobj::Material) -> f64 {
        match from.optical_density {
            Some(ior) if (1.0..=1000.0).contains(&ior) => ior,
            Some(ior) => {
                self.warn(from, &format!("has Ni {ior}, taken as {DEFAULT_IOR}"));
                DEFAULT_IOR
            }
            None => DEFAULT_IOR,
        }
    }

    fn warn(&mut self, from: &tobj::Material, sentence: &str) {
        let file = self.file.display();
        self.warnings
            .push(format!("{file}: material `{}` {sentence}", from.name));
    }

    /// The texture that `map`, the value of `key`, names; where it cannot be read, that is a
    /// warning.
    fn texture(
        &mut self,
        from: &tobj::Material,
        key: &str,
        map: Option<&str>,
        meaning: Meaning,
    ) -> Option<TextureUse> {
        let map = Map::parse(map?);
        if map.has_other_options {
            self.ignored.insert(format!("options of {key}"));
        }
        let field = format!("{key} of `{}`", from.name);
        let found = find(&self.folders, map.name, self.file, &field);
        let texture = found.and_then(|f| self.textures.get(&f, None, meaning, || files::read(&f)));
        let texture = texture.map_err(|error| {
            let sentence = format!("{error}; the texture is left out");
            self.warnings.push(sentence);
        });
        Some(TextureUse {
            texture: texture.ok()?,
            transform: map.transform(),
            wrap: map.wrap,
            interpolation: Interpolation::Linear,
            second_uvs: false,
        })
    }

    /// Notes what `from` says that no material of direkt shows.
    fn note_ignored(&mut self, from: &tobj::Material, through: bool) {
        let tints = |c: [f64; 3]| c.iter().any(|channel| channel.abs() > 0.0);
        let mut ignore = |holds: bool, key: &str| {
            if holds {
                self.ignored.insert(key.to_owned());
            }
        };
        ignore(from.ambient.is_some_and(tints), "Ka");
        ignore(from.ambient_texture.is_some(), "map_Ka");
        ignore(from.specular_texture.is_some(), "map_Ks");
        ignore(from.shininess_texture.is_some(), "map_Ns");
        ignore(
            from.normal_texture.is_some(),
            "map_bump (a height; a normal map is `norm`)",
        );
        for (key, value) in &from.unknown_param {
            let changes_nothing = match key.as_str() {
                "Pr" | "Pm" | "Tr" | "norm" | "map_Ke" => true,
                "Tf" => through || color(from, "Tf") == Some([1.0; 3]),
                _ => text::number(value).is_some_and(|n| n.abs() <= 0.0),
            };
            ignore(!changes_nothing, key);
        }
    }
}

fn parameter<'m>(from: &'m tobj::Material, key: &str) -> Option<&'m str> {
    from.unknown_param.get(key).map(String::as_str)
}

fn number(from: &tobj::Material, key: &str) -> Option<f64> {
    text::number(parameter(from, key)?)
}

fn color(from: &tobj::Material, key: &str) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = parameter(from, key)?
        .split_whitespace()
        .map(text::number)
        .collect();
    numbers?.try_into().ok()
}

/// A map: options, then the name of a file.
struct Map<'a> {
    name: &'a str,
    scale: DVec2,
    offset: DVec2,
    wrap: [Wrap; 2],
    has_other_options: bool,
}

impl<'a> Map<'a> {
    fn parse(value: &'a str) -> Self {
        let mut map = Self {
            name: value.trim(),
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            wrap: [Wrap::Repeat; 2],
            has_other_options: false,
        };
        while map.name.starts_with('-') {
            let (option, rest) = next_word(map.name);
            match option {
                "-s" => map.name = numbers(rest, &mut map.scale),
                "-o" => map.name = numbers(rest, &mut map.offset),
                "-clamp" => {
                    let (value, rest) = next_word(rest);
                    if value == "on" {
                        map.wrap = [Wrap::Clamp; 2];
                    }
                    map.name = rest;
                }
                "-t" | "-mm" => {
                    map.has_other_options = true;
                    let mut unused = DVec2::ZERO;
                    map.name = numbers(rest, &mut unused);
                }
                "-bm" | "-boost" | "-texres" | "-imfchan" | "-type" | "-cc" | "-blendu"
                | "-blendv" | "-colorspace" => {
                    let (value, rest) = next_word(rest);
                    map.has_other_options |= !matches!(value, "on" | "off" | "m" | "l");
                    map.name = rest;
                }
                // A name that begins with a dash.
                _ => break,
            }
        }
        map
    }

    /// From texture coordinates whose v points down to those of the image: the library's v points
    /// up.
    fn transform(&self) -> DAffine2 {
        let down = 1.0 - self.scale.y - self.offset.y;
        DAffine2::from_mat2_translation(
            DMat2::from_diagonal(self.scale),
            DVec2::new(self.offset.x, down),
        )
    }
}

fn next_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// Reads one to three numbers, of which two count; returns what stands behind them.
fn numbers<'a>(text: &'a str, into: &mut DVec2) -> &'a str {
    let mut rest = text;
    for i in 0..3 {
        let (word, behind) = next_word(rest);
        let Some(number) = text::number(word).filter(|n| n.is_finite() && !behind.is_empty())
        else {
            break;
        };
        if i < 2 {
            into[i] = number;
        }
        rest = behind;
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_options() {
        let map = Map::parse("-s 2 3 1 -o 0.25 0.5 -clamp on my wood.png");
        assert_eq!(map.name, "my wood.png");
        assert!(!map.has_other_options);
        assert_eq!(map.wrap, [Wrap::Clamp; 2]);
        // v = 1 of the mesh, the image's upper edge before it is moved, is at 3·1 + ½ from below.
        let moved = map.transform().transform_point2(DVec2::ZERO);
        assert_eq!(moved, DVec2::new(0.25, 1.0 - 3.5));
        let map = Map::parse("-bm 0.5 -dash.png");
        assert!(map.has_other_options);
        assert_eq!(map.name, "-dash.png");
        assert_eq!(Map::parse("-s 2 7").name, "7");
    }
}
