//! Lights without a surface, and the environment.

use super::build::Context;
use super::format::{EnvironmentTable, LightTable};
use crate::error::InputError;
use crate::scene::load::image;
use crate::scene::{Environment, EnvironmentRadiance, Light};
use glam::{DMat3, DVec3};

/// The lights of the `[[lights]]` tables.
pub(super) fn all(context: &mut Context, tables: &[LightTable]) -> Result<Vec<Light>, InputError> {
    let mut lights = Vec::with_capacity(tables.len());
    for (index, table) in tables.iter().enumerate() {
        let field = format!("lights[{index}]");
        if let Some(group) = context.group(table.group.as_deref(), &field)? {
            context.light_groups.add_light(index, group);
        }
        let light = table.kind.light();
        lights.push(light.map_err(|fault| fault.at(context.path, &field))?);
    }
    Ok(lights)
}

/// The `[environment]` table.
pub(super) fn environment(
    context: &mut Context,
    table: &EnvironmentTable,
) -> Result<Environment, InputError> {
    let radiance = match (&table.radiance, &table.file) {
        (Some(rgb), None) => EnvironmentRadiance::Constant(DVec3::from(*rgb)),
        (None, Some(file)) => {
            let path = context
                .folders
                .resolve(file, context.path, "environment.file")?;
            let mut map =
                image::read_environment(&path, table.layer.as_deref(), &mut context.warnings)?;
            map.interpolation = table.interpolation;
            EnvironmentRadiance::Map(map)
        }
        _ => {
            return Err(context.error(
                "environment",
                "the radiance is given twice or not at all",
                "`radiance` or `file`",
            ));
        }
    };
    if let Some(group) = context.group(table.group.as_deref(), "environment")? {
        context.light_groups.set_environment(group);
    }
    Ok(Environment {
        radiance,
        rotation: DMat3::from_rotation_y(table.rotation.to_radians()),
        scale: table.scale,
    })
}
