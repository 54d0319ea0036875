//! What a file uses and direkt does not do: one sentence for each kind.

use super::document::{Document, SUPPORTED_EXTENSIONS};
use super::lights;
use super::materials::Materials;
use super::nodes::Placed;
use gltf::json;
use gltf::json::material::{AlphaMode, Material};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// Everything that a scene made of this file leaves out.
pub(super) fn warnings(
    document: &Document,
    placed: &[Placed],
    materials: &Materials,
) -> Vec<String> {
    let file = document.file_name();
    let mut warnings = Vec::new();
    material_warnings(document, materials, &mut warnings);
    warnings.append(&mut geometry_warnings(document, placed));
    camera_and_light_warnings(document, placed, &mut warnings);
    let root = &document.root;
    if !root.animations.is_empty() {
        warnings.push(format!(
            "{file}: {} ignored: the scene is rendered as it stands",
            are(root.animations.len(), "animation")
        ));
    }
    if root.scenes.len() > 1 {
        warnings.push(format!(
            "{file}: only the default one of {} scenes is rendered",
            root.scenes.len()
        ));
    }
    for extension in &root.extensions_used {
        if !SUPPORTED_EXTENSIONS.contains(&extension.as_str()) {
            warnings.push(format!(
                "{file}: the extension {extension} is not supported and ignored"
            ));
        }
    }
    warnings
}

/// What is left out when only the geometry is used.
pub(super) fn geometry_warnings(document: &Document, placed: &[Placed]) -> Vec<String> {
    let file = document.file_name();
    let mut warnings = Vec::new();
    let mut add = |count: usize, what: &str, consequence: &str| {
        if count > 0 {
            let s = if count == 1 { "" } else { "s" };
            warnings.push(format!(
                "{file}: {what} of {count} primitive{s} {consequence}"
            ));
        }
    };
    let count = |condition: &dyn Fn(&Primitive) -> bool| {
        primitives(document, placed)
            .filter(|p| condition(p))
            .count()
    };
    let has = |p: &Primitive, wanted: &dyn Fn(&Semantic) -> bool| {
        p.attributes
            .keys()
            .any(|k| matches!(k, Checked::Valid(s) if wanted(s)))
    };
    add(
        count(&|p| has(p, &|s| matches!(s, Semantic::Normals))),
        "vertex normals",
        "are not supported yet: surfaces are shaded flat",
    );
    add(
        count(&|p| has(p, &|s| matches!(s, Semantic::Colors(_)))),
        "vertex colours",
        "are not supported and ignored",
    );
    add(
        count(&|p| p.targets.as_ref().is_some_and(|t| !t.is_empty())),
        "morph targets",
        "are not supported: the base shape is rendered",
    );
    add(
        count(&|p| {
            !matches!(
                p.mode,
                Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
            )
        }),
        "points and lines",
        "are not rendered",
    );
    let skinned = placed
        .iter()
        .filter(|n| document.root.nodes[n.index].skin.is_some())
        .count();
    if skinned > 0 {
        let s = if skinned == 1 { "" } else { "s" };
        warnings.push(format!(
            "{file}: skins of {skinned} node{s} are not supported: the mesh is rendered in its rest pose"
        ));
    }
    warnings
}

/// The primitives that placed nodes show, each once per node.
fn primitives<'a>(
    document: &'a Document,
    placed: &'a [Placed],
) -> impl Iterator<Item = &'a Primitive> {
    placed
        .iter()
        .filter_map(|n| document.root.nodes[n.index].mesh)
        .filter_map(|m| document.root.meshes.get(m.value()))
        .flat_map(|m| &m.primitives)
}

fn material_warnings(document: &Document, materials: &Materials, warnings: &mut Vec<String>) {
    type Uses = fn(&Material) -> bool;
    let textures: [(&str, Uses); 5] = [
        ("baseColorTexture", |m| {
            m.pbr_metallic_roughness.base_color_texture.is_some()
        }),
        ("metallicRoughnessTexture", |m| {
            m.pbr_metallic_roughness
                .metallic_roughness_texture
                .is_some()
        }),
        ("normalTexture", |m| m.normal_texture.is_some()),
        ("occlusionTexture", |m| m.occlusion_texture.is_some()),
        ("emissiveTexture", |m| m.emissive_texture.is_some()),
    ];
    let file = document.file_name();
    let used: Vec<&json::Material> = materials
        .used_indices()
        .filter_map(|i| document.root.materials.get(i))
        .collect();
    for (texture, uses) in textures {
        let count = used.iter().filter(|m| uses(m)).count();
        if count == 0 {
            continue;
        }
        let (of, factors) = if count == 1 {
            ("1 material".to_owned(), "its")
        } else {
            (format!("{count} materials"), "their")
        };
        let consequence = match texture {
            "normalTexture" => "surfaces are shaded flat".to_owned(),
            "occlusionTexture" => "light paths are traced instead".to_owned(),
            _ => format!("{factors} factors are used"),
        };
        warnings.push(format!(
            "{file}: textures are not supported yet: {texture} of {of} is ignored, {consequence}"
        ));
    }
    for (mode, name) in [(AlphaMode::Mask, "MASK"), (AlphaMode::Blend, "BLEND")] {
        let count = used
            .iter()
            .filter(|m| m.alpha_mode == Checked::Valid(mode))
            .count();
        if count > 0 {
            let s = if count == 1 { "" } else { "s" };
            warnings.push(format!(
                "{file}: alphaMode {name} of {count} material{s} is not supported: rendered opaque"
            ));
        }
    }
}

fn camera_and_light_warnings(document: &Document, placed: &[Placed], warnings: &mut Vec<String>) {
    let file = document.file_name();
    let cameras: Vec<&json::Camera> = placed
        .iter()
        .filter_map(|n| document.root.nodes[n.index].camera)
        .filter_map(|c| document.root.cameras.get(c.value()))
        .collect();
    let usable = |c: &&&json::Camera| c.perspective.is_some() || c.orthographic.is_some();
    let usable = cameras.iter().filter(usable).count();
    if usable > 1 {
        warnings.push(format!("{file}: the first of {usable} cameras is used"));
    }
    let ranged = placed
        .iter()
        .filter_map(|n| lights::light_of(document, n))
        .filter_map(|i| lights::list(document).get(i))
        .filter(|l| l.range.is_some())
        .count();
    if ranged > 0 {
        let s = if ranged == 1 { "" } else { "s" };
        warnings.push(format!(
            "{file}: the range of {ranged} light{s} is ignored: light falls off with the square of the distance alone"
        ));
    }
}

/// `1 animation is`, `2 animations are`.
fn are(count: usize, what: &str) -> String {
    if count == 1 {
        format!("1 {what} is")
    } else {
        format!("{count} {what}s are")
    }
}
