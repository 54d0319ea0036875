//! Checks of materials.

use crate::error::InputError;
use crate::scene::material::DielectricLayer;
use crate::scene::{Bsdf, Material, Texels, Texture, TextureUse};
use glam::DVec3;
use half::f16;
use std::path::Path;

/// Largest index of refraction.
const MAX_INDEX: f64 = 1000.0;

type Outcome = Result<(), InputError>;

/// One material of a file.
struct Check<'a> {
    file: &'a Path,
    name: &'a str,
}

/// Checks that an image has the texels that its size says, and that they are numbers.
pub(super) fn texels(file: &Path, texture: &Texture, index: usize) -> Outcome {
    let error = |problem: String, expected: &str| {
        Err(InputError::new(
            file,
            format!("textures[{index}]"),
            problem,
            expected,
        ))
    };
    let (width, height) = (texture.width, texture.height);
    let sides = 1..=Texture::MAX_SIDE;
    if !(sides.contains(&width) && sides.contains(&height)) {
        return error(
            format!("has {width} × {height} texels"),
            "1 to 16384 a side",
        );
    }
    let (count, are_numbers) = match &texture.texels {
        Texels::Bytes(texels) => (texels.len(), true),
        Texels::Halves(texels) => {
            let mut numbers = texels.iter().flatten();
            // By bits, as loaded images of many millions pass through here as well.
            let are_numbers =
                numbers.all(|x| *x == f16::NEG_ZERO || x.to_bits() < f16::INFINITY.to_bits());
            (texels.len(), are_numbers)
        }
    };
    if count as u64 != u64::from(width) * u64::from(height) {
        let problem = format!("has {count} texels for {width} × {height}");
        return error(problem, "width times height");
    }
    if !are_numbers {
        return error(
            "has texels that are no numbers".to_owned(),
            "finite ones, not negative",
        );
    }
    Ok(())
}

/// Checks that `field` reads a texture that exists, of the `count` that there are.
pub(super) fn texture_use(file: &Path, used: TextureUse, count: usize, field: &str) -> Outcome {
    if used.texture.index() >= count {
        let problem = format!("is texture {} of {count}", used.texture.0);
        let expected = "an index into the scene's textures";
        return Err(InputError::new(file, field, problem, expected));
    }
    if !used.transform.is_finite() {
        let problem = format!("are repeated {} times", used.transform.matrix2);
        return Err(InputError::new(file, field, problem, "finite numbers"));
    }
    Ok(())
}

/// Checks that `material` reads textures that exist, `count` of them, and that mean something for
/// it.
pub(super) fn textures(file: &Path, material: &Material, count: usize) -> Outcome {
    let maps = &material.textures;
    let error = |key: &str, problem: String, expected: &str| {
        let field = format!("materials.{}.textures{key}", material.name);
        Err(InputError::new(file, field, problem, expected))
    };
    for texture in material.texture_uses() {
        let field = format!("materials.{}.textures", material.name);
        texture_use(file, texture, count, &field)?;
    }
    let scale = maps.normal.map_or(1.0, |map| map.scale);
    if !scale.is_finite() {
        return error(".normal_scale", format!("is {scale}"), "a finite number");
    }
    let metal = matches!(material.bsdf, Bsdf::Metal { .. });
    if metal && maps.color.is_some() {
        let problem = "colours a metal that is given by its index of refraction".to_owned();
        return error(".color", problem, "a conductor with a `reflectance`");
    }
    let model = matches!(material.bsdf, Bsdf::MetallicRoughness { .. });
    if !model && maps.metallic_roughness.is_some() {
        let problem = "varies a material that has no metallic and roughness".to_owned();
        return error(
            ".metallic_roughness",
            problem,
            "a material of type \"metallic-roughness\"",
        );
    }
    Ok(())
}

/// Checks that every number of `material` is in its domain.
pub(super) fn check(file: &Path, material: &Material) -> Outcome {
    let check = Check {
        file,
        name: &material.name,
    };
    check.number(material.opacity.factor, "opacity")?;
    if let Some(cutoff) = material.opacity.cutoff {
        let holds = cutoff.is_finite() && cutoff >= 0.0;
        let expected = "a finite number, not negative: the least opacity that is opaque";
        check.require(holds, "alpha_cutoff", cutoff, expected)?;
    }
    match material.bsdf {
        Bsdf::Lambert { reflectance } | Bsdf::Mirror { reflectance } => {
            check.colour(reflectance, "reflectance")
        }
        Bsdf::Unlit { color } => check.colour(color, "color"),
        Bsdf::SpecularGlossiness {
            diffuse,
            specular,
            glossiness,
            ..
        } => {
            check.colour(diffuse, "diffuseFactor")?;
            check.colour(specular, "specularFactor")?;
            check.number(glossiness, "glossinessFactor")
        }
        Bsdf::Dielectric {
            ior,
            transmittance,
            thin,
        } => {
            let holds = (1.0 / MAX_INDEX..=MAX_INDEX).contains(&ior) && (ior >= 1.0 || !thin);
            let expected =
                "the index inside over that outside, 0.001 to 1000, of a thin pane from 1";
            check.require(holds, "ior", ior, expected)?;
            check.colour(transmittance, "transmittance")?;
            check.both_sides(material.double_sided || thin)
        }
        Bsdf::Conductor { reflectance, alpha } => {
            check.colour(reflectance, "reflectance")?;
            check.number(alpha, "alpha")
        }
        Bsdf::Metal { eta, k, alpha } => {
            let positive = eta.cmpgt(DVec3::ZERO).all() && eta.cmple(DVec3::splat(MAX_INDEX)).all();
            let expected = "each channel above 0 and up to 1000";
            check.require(positive, "eta", eta, expected)?;
            let valid = k.cmpge(DVec3::ZERO).all() && k.cmple(DVec3::splat(MAX_INDEX)).all();
            check.require(valid, "k", k, "each channel from 0 to 1000")?;
            check.number(alpha, "alpha")
        }
        Bsdf::Plastic {
            reflectance,
            ior,
            alpha,
        } => {
            check.colour(reflectance, "reflectance")?;
            check.ior(ior, "ior")?;
            check.number(alpha, "alpha")
        }
        Bsdf::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            layer,
        } => {
            check.colour(base_color, "base_color")?;
            check.number(metallic, "metallic")?;
            check.number(roughness, "roughness")?;
            check.layer(&layer)?;
            let solid = layer.transmission > 0.0 && metallic < 1.0 && !layer.thin;
            check.both_sides(material.double_sided || !solid)
        }
    }
}

impl Check<'_> {
    fn require(
        &self,
        holds: bool,
        key: &str,
        value: impl std::fmt::Display,
        expected: &str,
    ) -> Outcome {
        if holds {
            return Ok(());
        }
        let field = format!("materials.{}.{key}", self.name);
        Err(InputError::new(
            self.file,
            field,
            format!("is {value}"),
            expected,
        ))
    }

    fn colour(&self, value: DVec3, key: &str) -> Outcome {
        let holds = value.cmpge(DVec3::ZERO).all() && value.cmple(DVec3::ONE).all();
        self.require(holds, key, value, "each channel from 0 to 1")
    }

    fn number(&self, value: f64, key: &str) -> Outcome {
        let holds = (0.0..=1.0).contains(&value);
        self.require(holds, key, value, "a number from 0 to 1")
    }

    fn ior(&self, value: f64, key: &str) -> Outcome {
        let holds = (1.0..=MAX_INDEX).contains(&value);
        self.require(holds, key, value, "an index of refraction from 1 to 1000")
    }

    fn layer(&self, layer: &DielectricLayer) -> Outcome {
        if layer.ior != 0.0 || layer.transmission > 0.0 {
            self.ior(layer.ior, "ior")?;
        }
        self.number(layer.specular, "specular")?;
        let colour = layer.specular_color;
        let holds = colour.is_finite() && colour.cmpge(DVec3::ZERO).all();
        self.require(
            holds,
            "specular_color",
            colour,
            "finite numbers, not negative",
        )?;
        self.number(layer.transmission, "transmission")
    }

    fn both_sides(&self, holds: bool) -> Outcome {
        let expected = "true: light leaves a body of glass through the back of its surface";
        self.require(holds, "double_sided", false, expected)
    }
}
