//! Links WESL modules into one WGSL module.

use super::specialize::SpecializedScene;
use crate::accel::parts::Split;
use crate::error::GpuError;
use crate::prepare::Prepared;
use anstream::adapter::strip_str;
use include_dir::{Dir, include_dir};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use wesl::{ManglerKind, ModulePath, VirtualResolver, Wesl};

static EMBEDDED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/shaders");

pub use crate::error::SHADERS_VARIABLE;

/// Values that differ between kernels and that WGSL needs as constants; they appear in the module
/// `package::config`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KernelConstants {
    /// Entries of the traversal's stack.
    pub stack_depth: u32,
    /// Any number but 0, with which unfinished work is marked: with another one a driver has to
    /// compile anew what it may have kept.
    pub stamp: u32,
    /// Groups of lights that are kept apart.
    pub light_groups: u32,
    /// That of the environment.
    pub environment_group: u32,
    /// Boxes around what emits.
    pub light_boxes: u32,
    /// How nodes, primitives and attributes are split, where they are.
    pub split: Option<Split>,
    /// The scene, where the kernel is specialized for it.
    pub specialized: Option<SpecializedScene>,
}

impl Default for KernelConstants {
    fn default() -> Self {
        Self {
            stack_depth: 4,
            stamp: 1,
            light_groups: 1,
            environment_group: 0,
            light_boxes: 0,
            split: None,
            specialized: None,
        }
    }
}

impl KernelConstants {
    /// The values for `prepared`.
    pub fn of(prepared: &Prepared) -> Self {
        let emitters = &prepared.emitters;
        let environment = emitters.index_of_environment();
        Self {
            stack_depth: prepared.data.stack_depth(),
            light_groups: emitters.groups.count(),
            environment_group: environment.map_or(0, |index| emitters.groups.of_light(index)),
            light_boxes: prepared.light_boxes.len() as u32,
            split: prepared.data.split,
            specialized: SpecializedScene::of(prepared),
            ..Self::default()
        }
    }

    fn to_wesl(&self) -> String {
        let constants = [
            ("STACK_DEPTH", self.stack_depth),
            ("STAMP", self.stamp),
            ("LIGHT_GROUP_COUNT", self.light_groups),
            ("ENVIRONMENT_GROUP", self.environment_group),
            ("LIGHT_BOX_COUNT", self.light_boxes),
        ];
        let parts = self.split.map(|split| {
            [
                ("NODES_PER_PART", split.nodes as u32),
                ("PRIMITIVES_PER_PART", split.primitives as u32),
                ("WORDS_PER_PART", split.words as u32),
            ]
        });
        let constants = constants.into_iter().chain(parts.into_iter().flatten());
        let lines = constants.map(|(name, value)| format!("const {name}: u32 = {value}u;\n"));
        lines.collect()
    }
}

/// Links `entry` (for example `kernel::direct`) with the given features and returns plain WGSL.
///
/// # Errors
/// A module is missing, or WESL finds a mistake in one.
pub fn link<'a>(
    entry: &str,
    features: impl IntoIterator<Item = (&'a str, bool)>,
    constants: &KernelConstants,
) -> Result<String, GpuError> {
    link_with(entry, None, features, constants)
}

/// Like [`link`], for an entry module whose text is `source` (test kernels).
pub fn link_with<'a>(
    entry: &str,
    source: Option<&str>,
    features: impl IntoIterator<Item = (&'a str, bool)>,
    constants: &KernelConstants,
) -> Result<String, GpuError> {
    let fail = |message: String| GpuError::Shader {
        entry: entry.to_owned(),
        message,
    };
    let mut resolver = VirtualResolver::new();
    let mut add = |name: &str, text: String| -> Result<(), GpuError> {
        let path: ModulePath = format!("package::{name}")
            .parse()
            .map_err(|e| fail(format!("module name `{name}`: {e}")))?;
        resolver.add_module(path, Cow::Owned(text));
        Ok(())
    };
    for (name, text) in modules().map_err(&fail)? {
        add(&name, text)?;
    }
    add("config", constants.to_wesl())?;
    let specialized = constants.specialized.as_ref();
    add(
        "specialized",
        specialized.map_or_else(String::new, |w| w.text().to_owned()),
    )?;
    if let Some(source) = source {
        add(entry, source.to_owned())?;
    }
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
    compiler.set_options(wesl::CompileOptions {
        imports: true,
        condcomp: true,
        strip: true,
        lazy: true,
        validate: false,
        ..Default::default()
    });
    compiler.set_mangler(ManglerKind::None);
    compiler.use_sourcemap(true);
    compiler.set_features(features);
    let root: ModulePath = format!("package::{entry}")
        .parse()
        .map_err(|e| fail(format!("entry: {e}")))?;
    compiler
        .compile(&root)
        .map(|linked| linked.to_string())
        .map_err(|e| fail(strip_str(&e.to_string()).to_string()))
}

/// All modules as (`light::triangle`, text).
fn modules() -> Result<Vec<(String, String)>, String> {
    match std::env::var_os(SHADERS_VARIABLE) {
        Some(folder) => on_disk(Path::new(&folder)),
        None => Ok(embedded(&EMBEDDED)),
    }
}

fn embedded(dir: &Dir<'_>) -> Vec<(String, String)> {
    let mut out: Vec<_> = dir
        .files()
        .filter_map(|f| Some((module_name(f.path())?, f.contents_utf8()?.to_owned())))
        .collect();
    out.extend(dir.dirs().flat_map(embedded));
    out
}

fn on_disk(folder: &Path) -> Result<Vec<(String, String)>, String> {
    let mut out = Vec::new();
    for path in files_in(folder)? {
        if let Some(name) = path.strip_prefix(folder).ok().and_then(module_name) {
            let text = std::fs::read_to_string(&path)
                .map_err(|e| format!("{SHADERS_VARIABLE}: {}: {e}", path.display()))?;
            out.push((name, text));
        }
    }
    Ok(out)
}

/// The files of the folder that [`SHADERS_VARIABLE`] names; none where it names none.
pub fn own_files() -> Vec<PathBuf> {
    let folder = std::env::var_os(SHADERS_VARIABLE);
    // A folder that cannot be read is an error when shaders are.
    folder.map_or_else(Vec::new, |f| files_in(Path::new(&f)).unwrap_or_default())
}

fn files_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    let mut pending: Vec<PathBuf> = vec![folder.to_path_buf()];
    while let Some(dir) = pending.pop() {
        let problem = |e: std::io::Error| format!("{SHADERS_VARIABLE}: {}: {e}", dir.display());
        for entry in std::fs::read_dir(&dir).map_err(problem)? {
            let path = entry.map_err(problem)?.path();
            if path.is_dir() {
                pending.push(path);
            } else {
                files.push(path);
            }
        }
    }
    Ok(files)
}

/// `light/triangle.wesl` → `light::triangle`; `None` for other files.
fn module_name(path: &Path) -> Option<String> {
    if path.extension()? != "wesl" {
        return None;
    }
    let parts: Option<Vec<&str>> = path.iter().map(|p| p.to_str()).collect();
    Some(parts?.join("::").trim_end_matches(".wesl").to_owned())
}
