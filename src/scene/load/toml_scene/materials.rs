//! What the tables of materials mean.

use super::build::Context;
use super::format_materials::{ConductorTable, MaterialKind, MaterialTable};
use crate::error::InputError;
use crate::scene::material::DielectricLayer;
use crate::scene::{Bsdf, Material, MaterialTextures, Opacity};
use glam::DVec3;

/// The material `name`.
pub(super) fn material(
    context: &Context,
    name: String,
    table: &MaterialTable,
    (textures, opacity): (MaterialTextures, Opacity),
) -> Result<Material, InputError> {
    let bsdf = match &table.kind {
        MaterialKind::Lambert(t) => Bsdf::Lambert {
            reflectance: DVec3::from_array(t.reflectance.0),
        },
        MaterialKind::Mirror(t) => Bsdf::Mirror {
            reflectance: DVec3::from_array(t.reflectance.0),
        },
        MaterialKind::Dielectric(t) => Bsdf::Dielectric {
            ior: t.ior,
            transmittance: DVec3::from_array(t.transmittance.0),
            thin: t.thin,
        },
        MaterialKind::Conductor(t) => conductor(context, &name, t)?,
        MaterialKind::Plastic(t) => Bsdf::Plastic {
            reflectance: DVec3::from_array(t.reflectance.0),
            ior: t.ior,
            alpha: t.alpha,
        },
        MaterialKind::Unlit(t) => Bsdf::Unlit {
            color: DVec3::from_array(t.color.0),
        },
        MaterialKind::MetallicRoughness(t) => Bsdf::MetallicRoughness {
            base_color: DVec3::from_array(t.base_color.0),
            metallic: t.metallic,
            roughness: t.roughness,
            layer: DielectricLayer {
                ior: t.ior,
                specular: t.specular,
                specular_color: DVec3::from_array(t.specular_color.0),
                transmission: t.transmission,
                thin: t.thin,
                metal_mask: false,
            },
        },
    };
    Ok(Material {
        name,
        bsdf,
        double_sided: table.double_sided,
        textures,
        opacity,
    })
}

fn conductor(context: &Context, name: &str, t: &ConductorTable) -> Result<Bsdf, InputError> {
    let alpha = t.alpha;
    match (t.reflectance, t.eta, t.k, t.metal) {
        (Some(reflectance), None, None, None) => Ok(Bsdf::Conductor {
            reflectance: DVec3::from_array(reflectance.0),
            alpha,
        }),
        (None, Some(eta), Some(k), None) => Ok(Bsdf::Metal {
            eta: DVec3::from_array(eta.0),
            k: DVec3::from_array(k.0),
            alpha,
        }),
        (None, None, None, Some(metal)) => {
            let (eta, k) = metal.index();
            Ok(Bsdf::Metal { eta, k, alpha })
        }
        _ => Err(context.error(
            format!("materials.{name}"),
            "its reflectance is given in parts, twice or not at all",
            "`reflectance`, or `eta` and `k`, or `metal`",
        )),
    }
}
