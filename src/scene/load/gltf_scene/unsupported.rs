//! What a file uses and direkt does not do: one sentence for each kind.

use super::coordinates::{asked_sets, has_set};
use super::document::Document;
use super::lights;
use super::materials::Materials;
use super::nodes::Placed;
use gltf::json;
use gltf::json::material::Material;
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
    extension_warnings(document, materials, &mut warnings);
    warnings.append(&mut geometry_warnings(document, placed));
    camera_and_light_warnings(document, placed, &mut warnings);
    let root = &document.root;
    if !root.animations.is_empty() {
        warnings.push(format!(
            "{file}: {} ignored: the scene is rendered as it stands",
            are(root.animations.len(), "animation")
        ));
    }
    if root.scenes.is_empty() && !placed.is_empty() {
        warnings.push(format!(
            "{file}: there is no scene: all of its nodes are rendered"
        ));
    }
    if root.scenes.len() > 1 {
        warnings.push(format!(
            "{file}: only the default one of {} scenes is rendered",
            root.scenes.len()
        ));
    }
    for extension in document.unsupported_extensions() {
        warnings.push(format!(
            "{file}: the extension {extension} is not supported and ignored"
        ));
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
        count(&|p| lacks_coordinates(document, p)),
        "textures",
        "have no texture coordinates: their factors are used",
    );
    add(
        count(&|p| has(p, &|s| matches!(s, Semantic::Colors(set) if *set > 0))),
        "further vertex colours",
        "are ignored: COLOR_0 alone is read",
    );
    add(
        count(&|p| is_of_triangles(p) && !has(p, &|s| *s == Semantic::Positions)),
        "vertices",
        "have no POSITION and are not rendered",
    );
    add(
        count(&|p| !is_of_triangles(p)),
        "points and lines",
        "are not rendered",
    );
    warnings.extend(unread_morphs(document, placed));
    warnings
}

/// What morph targets displace beside positions, normals and tangents, where any of them has a
/// weight.
fn unread_morphs(document: &Document, placed: &[Placed]) -> Option<String> {
    let root = &document.root;
    let mut of_nodes = placed
        .iter()
        .filter_map(|n| root.nodes[n.index].weights.as_ref());
    let mut of_meshes = root.meshes.iter().filter_map(|m| m.weights.as_ref());
    let weighs = |weights: &Vec<f32>| weights.iter().any(|w| *w != 0.0);
    if document.unread_morphs.is_empty() || !(of_nodes.any(weighs) || of_meshes.any(weighs)) {
        return None;
    }
    let names: Vec<&str> = document.unread_morphs.iter().map(String::as_str).collect();
    Some(format!(
        "{}: morph targets displace positions, normals and tangents alone: their {} are ignored",
        document.file_name(),
        names.join(", ")
    ))
}

fn is_of_triangles(primitive: &Primitive) -> bool {
    matches!(
        primitive.mode,
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    )
}

/// Whether a texture of its material is read with texture coordinates that `primitive` does not
/// have.
fn lacks_coordinates(document: &Document, primitive: &Primitive) -> bool {
    let index = primitive.material.map(|m| m.value());
    let material = index.and_then(|i| document.root.materials.get(i));
    let asked = material.map_or_else(Vec::new, asked_sets);
    asked.iter().take(2).any(|&set| !has_set(primitive, set))
}

/// The primitives that placed nodes show, each once per node.
fn primitives<'a>(
    document: &'a Document,
    placed: &'a [Placed],
) -> impl Iterator<Item = &'a Primitive> {
    placed
        .iter()
        .filter(|n| n.visible)
        .filter_map(|n| document.root.nodes[n.index].mesh)
        .filter_map(|m| document.root.meshes.get(m.value()))
        .flat_map(|m| &m.primitives)
}

fn material_warnings(document: &Document, materials: &Materials, warnings: &mut Vec<String>) {
    let file = document.file_name();
    let used: Vec<&json::Material> = materials
        .used_indices()
        .filter_map(|i| document.root.materials.get(i))
        .collect();
    for material in materials.used_indices() {
        let Some(json) = document.root.materials.get(material) else {
            continue;
        };
        if let [first, second, further @ ..] = asked_sets(json).as_slice()
            && !further.is_empty()
        {
            let further: Vec<String> = further.iter().map(|n| format!("TEXCOORD_{n}")).collect();
            warnings.push(format!(
                "{file}: materials[{material}] reads textures with more than two sets of texture coordinates: beside TEXCOORD_{first} and TEXCOORD_{second}, those with {} are ignored",
                further.join(", ")
            ));
        }
    }
    let occluded = used.iter().filter(|m| m.occlusion_texture.is_some());
    let count = occluded.count();
    if count > 0 {
        let s = if count == 1 { "" } else { "s" };
        warnings.push(format!(
            "{file}: occlusionTexture of {count} material{s} is ignored, shadow rays are traced instead"
        ));
    }
}

/// What materials' extensions ask for beyond what is simulated.
fn extension_warnings(document: &Document, materials: &Materials, warnings: &mut Vec<String>) {
    type Uses = fn(&Material) -> bool;
    let parts: [(&str, Uses, &str); 2] = [
        (
            "KHR_materials_transmission",
            |m| {
                let pbr = &m.pbr_metallic_roughness;
                // A texture may make glass of what the factor calls metal.
                let glass = pbr.metallic_factor.0 < 1.0 || pbr.metallic_roughness_texture.is_some();
                let rough = pbr.roughness_factor.0 > 0.0 && glass;
                rough && transmission(m).is_some_and(|t| t.transmission_factor.0 > 0.0)
            },
            "roughness is ignored, the glass is smooth",
        ),
        (
            "KHR_materials_volume",
            |m| {
                let volume = m.extensions.as_ref().and_then(|e| e.volume.as_ref());
                volume.is_some_and(|v| {
                    v.attenuation_distance.0.is_finite() || v.thickness_texture.is_some()
                })
            },
            "attenuation and thickness textures are ignored, light is refracted but not absorbed",
        ),
    ];
    let file = document.file_name();
    for (extension, uses, consequence) in parts {
        let used = materials.used_indices();
        let used = used.filter_map(|i| document.root.materials.get(i));
        let count = used.filter(|m| uses(m)).count();
        if count > 0 {
            let s = if count == 1 { "" } else { "s" };
            warnings.push(format!(
                "{file}: {extension} of {count} material{s}: {consequence}"
            ));
        }
    }
}

fn transmission(material: &Material) -> Option<&json::extensions::material::Transmission> {
    material.extensions.as_ref()?.transmission.as_ref()
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
