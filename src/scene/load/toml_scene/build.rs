//! What the tables of a scene file mean.

use super::format::{GltfTable, SceneFile};
use super::format_shapes::TransformStep;
use super::{camera, expect, lights, materials as material_tables, shapes, textures};
use crate::error::InputError;
use crate::scene::load::files::{self, Folders};
use crate::scene::load::gltf_scene::FirstIds;
use crate::scene::load::texture::Textures;
use crate::scene::load::{frame, gltf_scene, transform};
use crate::scene::{Camera, LightGroups, MaterialId, Scene, ShapeId};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::collections::BTreeMap;
use std::path::Path;

/// What is known while a scene is built.
pub(super) struct Context<'a> {
    /// The scene file, for messages.
    pub(super) path: &'a Path,
    /// Where the files it names are looked up.
    pub(super) folders: &'a Folders,
    /// Ids of the named materials.
    pub(super) material_ids: BTreeMap<String, MaterialId>,
    /// Sentences for the user.
    pub(super) warnings: Vec<String>,
    /// Groups of lights so far.
    pub(super) light_groups: LightGroups,
}

impl Context<'_> {
    /// An error about `field` of the scene file.
    pub(super) fn error(
        &self,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> InputError {
        InputError::new(self.path, field, problem, expected)
    }

    /// The group of lights that `field` names.
    pub(super) fn group<'a>(
        &self,
        name: Option<&'a str>,
        field: &str,
    ) -> Result<Option<&'a str>, InputError> {
        match name.and_then(LightGroups::problem) {
            Some(problem) => Err(self.error(format!("{field}.group"), problem, LightGroups::NAME)),
            None => Ok(name),
        }
    }
}

/// The scene that `file`, read from `path`, describes.
pub(super) fn scene(path: &Path, folders: &Folders, file: SceneFile) -> Result<Scene, InputError> {
    let mut context = Context {
        path,
        folders,
        material_ids: BTreeMap::new(),
        warnings: Vec::new(),
        light_groups: LightGroups::default(),
    };
    let film = camera::film(&context, &file.film)?;
    let filter = camera::filter(&context, &file.film)?;
    let mut camera = file
        .camera
        .map(|c| camera::camera(&context, &c))
        .transpose()?;
    let mut materials = Vec::new();
    let mut textures = Textures::new(0);
    for (name, table) in file.materials {
        let id = MaterialId(u32::try_from(materials.len()).expect("fewer than 2³² materials"));
        let maps = textures::of_material(&context, &name, &table.textures, &mut textures)?;
        let opacity = textures::opacity(&context, &name, &table, &mut textures)?;
        let material = material_tables::material(&context, name.clone(), &table, (maps, opacity))?;
        materials.push(material);
        context.material_ids.insert(name, id);
    }
    let mut shapes = shapes::all(&mut context, file.shapes, &mut materials, &mut textures)?;
    let (mut textures, mut of_textures) = textures.into_parts();
    context.warnings.append(&mut of_textures);
    let mut lights = lights::all(&mut context, &file.lights)?;
    let environment = file
        .environment
        .map(|e| lights::environment(&mut context, &e))
        .transpose()?;
    for (index, table) in file.gltf.iter().enumerate() {
        let first = FirstIds {
            material: materials.len(),
            texture: textures.len(),
        };
        let mut part = include(&context, index, table, first)?;
        if let Some(group) = context.group(table.group.as_deref(), &format!("gltf[{index}]"))? {
            for shape in (shapes.len()..)
                .zip(&part.shapes)
                .filter(|(_, s)| s.emission.is_some())
            {
                context
                    .light_groups
                    .add_shape(ShapeId(shape.0 as u32), group);
            }
            for light in lights.len()..lights.len() + part.lights.len() {
                context.light_groups.add_light(light, group);
            }
        }
        textures.append(&mut part.textures);
        shapes.append(&mut part.shapes);
        materials.append(&mut part.materials);
        lights.append(&mut part.lights);
        context.warnings.append(&mut part.warnings);
        camera = camera.or(part.camera);
    }
    let expect = file
        .expect
        .map(|e| expect::expect(&context, e, film))
        .transpose()?;
    let camera = camera.unwrap_or_else(|| {
        let (camera, axis) = frame::framed(&shapes, &materials, film);
        context.warnings.push(format!(
            "the scene has no camera: one that looks along {axis} and frames the geometry is used"
        ));
        camera
    });
    Ok(Scene {
        source: path.to_path_buf(),
        camera,
        film,
        materials,
        textures,
        shapes,
        lights,
        environment,
        render: file.render.into(),
        expect,
        warnings: context.warnings,
        filter,
        light_groups: context.light_groups,
    })
}

/// An affine transform from a matrix by rows; `None` when the last row is another than `[0, 0, 0,
/// 1]`.
pub(super) fn affine(rows: &[[f64; 4]; 4]) -> Option<DAffine3> {
    let matrix = DMat4::from_cols_array_2d(rows).transpose();
    let last = matrix.row(3) - glam::DVec4::W;
    (last.abs().max_element() <= 0.0).then(|| DAffine3::from_mat4(matrix))
}

fn include(
    context: &Context,
    index: usize,
    table: &GltfTable,
    first: FirstIds,
) -> Result<gltf_scene::Imported, InputError> {
    let field = format!("gltf[{index}]");
    let placement = placement(context, &table.transform, &field)?;
    let file_field = format!("{field}.file");
    let file = context
        .folders
        .resolve(&table.file, context.path, &file_field)?;
    if !matches!(files::extension(&file).as_str(), "gltf" | "glb") {
        return Err(context.error(
            file_field,
            format!("`{}` is not a glTF", table.file),
            "a .gltf or .glb file; other meshes are shapes of type \"mesh\"",
        ));
    }
    let prefix = format!("{field}: ");
    gltf_scene::load_part(&file, context.folders, &placement, first, &prefix)
}

/// All steps of a transform, the first applied first; refused when singular.
pub(super) fn placement(
    context: &Context,
    steps: &[TransformStep],
    field: &str,
) -> Result<DAffine3, InputError> {
    let mut whole = DAffine3::IDENTITY;
    for (number, step) in steps.iter().enumerate() {
        whole = step_matrix(context, step, &format!("{field}.transform[{number}]"))? * whole;
    }
    transform::check(&whole).map_err(|problem| {
        let (problem, expected) = problem.describe();
        context.error(format!("{field}.transform"), problem, expected)
    })?;
    Ok(whole)
}

fn step_matrix(
    context: &Context,
    step: &TransformStep,
    field: &str,
) -> Result<DAffine3, InputError> {
    match step {
        TransformStep::Translate(v) => Ok(DAffine3::from_translation(DVec3::from_array(*v))),
        TransformStep::Scale(s) => Ok(DAffine3::from_scale(DVec3::from_array(s.0))),
        TransformStep::Rotate(r) => {
            let axis = direction(context, r.axis, &format!("{field}.rotate.axis"))?;
            Ok(DAffine3::from_axis_angle(axis, r.degrees.to_radians()))
        }
        TransformStep::Matrix(rows) => affine(rows).ok_or_else(|| {
            context.error(
                format!("{field}.matrix"),
                format!("its last row is {:?}", rows[3]),
                "[0, 0, 0, 1] (the matrix is written row by row)",
            )
        }),
        TransformStep::LookAt(l) => {
            let (from, to) = (DVec3::from_array(l.origin), DVec3::from_array(l.target));
            let camera =
                Camera::look_at(from, to, DVec3::from_array(l.up), 1.0).ok_or_else(|| {
                    context.error(
                        format!("{field}.look_at.target"),
                        format!("is the origin of the step, {:?}", l.origin),
                        "another point",
                    )
                })?;
            let turn = DMat3::from_cols(-camera.right, camera.up, camera.forward);
            Ok(DAffine3::from_mat3_translation(turn, from))
        }
    }
}

/// A unit vector.
pub(super) fn direction(context: &Context, v: [f64; 3], field: &str) -> Result<DVec3, InputError> {
    DVec3::from_array(v)
        .try_normalize()
        .ok_or_else(|| context.error(field, format!("is {v:?}"), "a direction that is not zero"))
}
