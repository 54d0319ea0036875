//! The `[[shapes]]` tables.

use super::build::{Context, direction, placement};
use super::format_shapes::{BoxTable, EmissionTable, RectangleTable, ShapeKind, ShapeTable};
use super::meshes::{self, Surfaces};
use super::textures::texture_use;
use crate::error::InputError;
use crate::scene::load::mesh;
use crate::scene::load::texture::{Meaning, Textures};
use crate::scene::load::transform;
use crate::scene::{
    Bsdf, Emission, Geometry, Material, MaterialId, MaterialTextures, Opacity, Shape, ShapeId,
};
use glam::DVec3;

/// A part of a shape, in the shape's own space.
pub(super) struct Part {
    /// What to add to the shape's name.
    pub(super) name: String,
    pub(super) geometry: Geometry,
    /// What its file says, where the scene file does not.
    pub(super) material: Option<MaterialId>,
    pub(super) emission: Option<Emission>,
}

impl Part {
    /// A part that is like the shape.
    pub(super) fn new(name: String, geometry: Geometry) -> Self {
        Self {
            name,
            geometry,
            material: None,
            emission: None,
        }
    }
}

/// The shapes of the scene file. A default material is added to `materials` when one is needed.
pub(super) fn all(
    context: &mut Context,
    tables: Vec<ShapeTable>,
    materials: &mut Vec<Material>,
    textures: &mut Textures,
) -> Result<Vec<Shape>, InputError> {
    let mut default_material = None;
    let mut shapes = Vec::new();
    for (index, table) in tables.into_iter().enumerate() {
        let field = format!("shapes[{index}]");
        let named = table.material.as_ref();
        let named = named.map(|name| named_material(context, name, &field));
        let named = named.transpose()?;
        let emission = table
            .emission
            .as_ref()
            .map(|e| emission(context, e, &field, textures))
            .transpose()?;
        let group = table.emission.as_ref().and_then(|e| e.group.as_deref());
        let group = context.group(group, &format!("{field}.emission"))?;
        let to_world = placement(context, &table.transform, &field)?;
        let name = match &table.name {
            Some(name) => format!("{field}: {name}"),
            None => field.clone(),
        };
        let mut dropped = 0;
        let mut surfaces = Surfaces {
            materials: &mut *materials,
            textures: &mut *textures,
            by_file: named.is_none(),
        };
        for part in parts(context, &table.kind, &field, &mut surfaces)? {
            let material = named.or(part.material);
            let material = material
                .unwrap_or_else(|| *default_material.get_or_insert_with(|| add_default(materials)));
            let emission = emission.or(part.emission);
            let mut geometry = transform::apply(&to_world, part.geometry);
            if let Geometry::Mesh(mesh) = &mut geometry {
                dropped += mesh::clean(mesh);
            }
            if emission.is_some_and(|e| e.texture.is_some()) {
                check_coordinates(context, &geometry, &field)?;
            }
            let name = format!("{name}{}", part.name);
            let of_shape = &materials[material.index()];
            let ignored = ignored_textures(of_shape, &geometry, &name);
            context.warnings.extend(ignored);
            if let Some(group) = group {
                let id = u32::try_from(shapes.len()).expect("fewer than 2³² shapes");
                context.light_groups.add_shape(ShapeId(id), group);
            }
            shapes.push(Shape {
                name,
                geometry,
                material,
                emission,
            });
        }
        if dropped > 0 {
            context.warnings.push(mesh::dropped_warning(&name, dropped));
        }
    }
    Ok(shapes)
}

fn emission(
    context: &Context,
    table: &EmissionTable,
    field: &str,
    textures: &mut Textures,
) -> Result<Emission, InputError> {
    let texture = match &table.texture {
        None => None,
        Some(texture) => {
            let field = format!("{field}.emission.texture");
            let read = texture_use(context, texture, &field, Meaning::Color, textures)?;
            Some(read)
        }
    };
    Ok(Emission {
        radiance: DVec3::from_array(table.radiance.0),
        texture,
        two_sided: table.two_sided,
    })
}

/// Why no texture can be laid over `geometry`, where none can.
fn lacks_coordinates(geometry: &Geometry) -> Option<&'static str> {
    match geometry {
        Geometry::Sphere { .. } | Geometry::Ellipsoid { .. } => {
            Some("a sphere has no texture coordinates")
        }
        Geometry::Mesh(mesh) if mesh.uvs.is_empty() => Some("the mesh has no texture coordinates"),
        _ => None,
    }
}

/// What is left out of a material of the scene file, where no texture can be laid over `geometry`.
fn ignored_textures(material: &Material, geometry: &Geometry, name: &str) -> Option<String> {
    let why = lacks_coordinates(geometry)?;
    let textured = material.texture_uses().next().is_some();
    textured.then(|| {
        format!(
            "{name}: material `{}` has textures, and {why}: its factors are used",
            material.name
        )
    })
}

/// Refuses a texture of emission that cannot be laid over `geometry`.
fn check_coordinates(
    context: &Context,
    geometry: &Geometry,
    field: &str,
) -> Result<(), InputError> {
    let Some(problem) = lacks_coordinates(geometry) else {
        return Ok(());
    };
    Err(context.error(
        format!("{field}.emission.texture"),
        problem,
        "a rectangle, a disk, a box or a mesh with texture coordinates",
    ))
}

fn named_material(context: &Context, name: &str, field: &str) -> Result<MaterialId, InputError> {
    context.material_ids.get(name).copied().ok_or_else(|| {
        let known: Vec<&str> = context.material_ids.keys().map(String::as_str).collect();
        context.error(
            format!("{field}.material"),
            format!("there is no material `{name}`"),
            if known.is_empty() {
                "a table [materials.NAME]; the file has none".to_owned()
            } else {
                format!("one of {}", known.join(", "))
            },
        )
    })
}

fn add_default(materials: &mut Vec<Material>) -> MaterialId {
    let id = MaterialId(u32::try_from(materials.len()).expect("fewer than 2³² materials"));
    materials.push(Material {
        name: "default".to_owned(),
        bsdf: Bsdf::Lambert {
            reflectance: DVec3::splat(0.5),
        },
        double_sided: true,
        textures: MaterialTextures::default(),
        opacity: Opacity::default(),
    });
    id
}

fn parts(
    context: &mut Context,
    kind: &ShapeKind,
    field: &str,
    surfaces: &mut Surfaces,
) -> Result<Vec<Part>, InputError> {
    let single = |geometry| vec![Part::new(String::new(), geometry)];
    match kind {
        ShapeKind::Rectangle(table) => rectangle(context, table, field).map(single),
        ShapeKind::Box(table) => box_faces(context, table, field),
        ShapeKind::Sphere(table) => Ok(single(Geometry::Sphere {
            center: DVec3::from_array(table.center),
            radius: radius(context, table.radius, field)?,
        })),
        ShapeKind::Disk(table) => {
            let normal = direction(context, table.normal, &format!("{field}.normal"))?;
            let radius = radius(context, table.radius, field)?;
            let (u, v) = transform::frame(normal);
            Ok(single(Geometry::Disk {
                center: DVec3::from_array(table.center),
                u: u * radius,
                v: v * radius,
            }))
        }
        ShapeKind::Mesh(table) => meshes::parts(context, table, field, surfaces),
    }
}

fn radius(context: &Context, radius: f64, field: &str) -> Result<f64, InputError> {
    if radius > 0.0 {
        Ok(radius)
    } else {
        let problem = format!("is {radius}");
        Err(context.error(format!("{field}.radius"), problem, "a number above 0"))
    }
}

fn rectangle(
    context: &Context,
    table: &RectangleTable,
    field: &str,
) -> Result<Geometry, InputError> {
    let (corner, u, v) = match (table.corner, table.u, table.v) {
        (None, None, None) => (DVec3::new(-1.0, -1.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Y),
        (Some(corner), Some(u), Some(v)) => (
            DVec3::from_array(corner),
            DVec3::from_array(u),
            DVec3::from_array(v),
        ),
        _ => {
            return Err(context.error(
                field,
                "gives only a part of `corner`, `u` and `v`",
                "all three, or none for the square [-1, 1]² in the xy plane",
            ));
        }
    };
    let area = u.cross(v).length();
    if area > 1e-12 * u.length() * v.length() {
        Ok(Geometry::Rectangle { corner, u, v })
    } else {
        Err(context.error(
            field,
            format!("`u` {u} and `v` {v} span no area"),
            "two edges in different directions",
        ))
    }
}

/// Six rectangles with outward normals.
fn box_faces(context: &Context, table: &BoxTable, field: &str) -> Result<Vec<Part>, InputError> {
    let (min, max) = match (table.min, table.max) {
        (None, None) => (DVec3::NEG_ONE, DVec3::ONE),
        (Some(min), Some(max)) => (DVec3::from_array(min), DVec3::from_array(max)),
        _ => {
            return Err(context.error(
                field,
                "gives only one of `min` and `max`",
                "both, or none for the cube [-1, 1]³",
            ));
        }
    };
    if !min.cmplt(max).all() {
        return Err(context.error(
            field,
            format!("`min` {min} is not below `max` {max} along every axis"),
            "a box with a volume",
        ));
    }
    let [x, y, z] = [
        DVec3::X * (max.x - min.x),
        DVec3::Y * (max.y - min.y),
        DVec3::Z * (max.z - min.z),
    ];
    let faces = [
        ("-x", min, z, y),
        ("+x", min + x, y, z),
        ("-y", min, x, z),
        ("+y", min + y, z, x),
        ("-z", min, y, x),
        ("+z", min + z, x, y),
    ];
    Ok(faces
        .into_iter()
        .map(|(face, corner, u, v)| {
            let name = format!(" (box face {face})");
            Part::new(name, Geometry::Rectangle { corner, u, v })
        })
        .collect())
}
