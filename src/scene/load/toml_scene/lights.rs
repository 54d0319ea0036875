//! Lights without a surface, and the environment.

use super::build::{Context, direction};
use super::format::{DirectionalTable, EnvironmentTable, LightKind, LightTable, SpotTable};
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
        lights.push(light(context, table, &field)?);
    }
    Ok(lights)
}

fn light(context: &Context, table: &LightTable, field: &str) -> Result<Light, InputError> {
    match &table.kind {
        LightKind::Point(t) => Ok(Light::Point {
            position: DVec3::from_array(t.position),
            intensity: DVec3::from_array(t.intensity.0),
        }),
        LightKind::Spot(t) => spot(context, t, field),
        LightKind::Directional(t) => directional(context, t, field),
    }
}

fn directional(
    context: &Context,
    table: &DirectionalTable,
    field: &str,
) -> Result<Light, InputError> {
    let direction = direction(context, table.direction, &format!("{field}.direction"))?;
    let irradiance = DVec3::from_array(table.irradiance.0);
    if table.angular_diameter == 0.0 {
        return Ok(Light::Directional {
            direction,
            irradiance,
        });
    }
    Ok(Light::Sun {
        direction,
        irradiance,
        angular_radius: 0.5 * table.angular_diameter.to_radians(),
    })
}

fn spot(context: &Context, table: &SpotTable, field: &str) -> Result<Light, InputError> {
    let position = DVec3::from_array(table.position);
    let direction = match (table.direction, table.target) {
        (Some(d), None) => direction(context, d, &format!("{field}.direction"))?,
        (None, Some(target)) => (DVec3::from_array(target) - position)
            .try_normalize()
            .ok_or_else(|| {
                context.error(
                    format!("{field}.target"),
                    format!("is the light's position, {target:?}"),
                    "a point that it shines at",
                )
            })?,
        _ => {
            return Err(context.error(
                field,
                "the direction is given twice or not at all",
                "`direction` or `target`",
            ));
        }
    };
    Ok(Light::Spot {
        position,
        direction,
        intensity: DVec3::from_array(table.intensity.0),
        inner_angle: table.inner.to_radians(),
        outer_angle: table.outer.to_radians(),
    })
}

/// The `[environment]` table.
pub(super) fn environment(
    context: &mut Context,
    table: &EnvironmentTable,
) -> Result<Environment, InputError> {
    let radiance = match (&table.radiance, &table.file) {
        (Some(rgb), None) => EnvironmentRadiance::Constant(DVec3::from_array(rgb.0)),
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
