//! Which channels of a file are its colours.
//!
//! A channel is called `LAYER.R` or `R`; the part of a file that it lies in may have a name
//! besides.

use crate::error::InputError;
use exr::meta::MetaData;
use exr::meta::header::Header;
use std::path::Path;

/// Channels by their places in a part's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channels {
    /// Red, green and blue.
    Rgb {
        rgb: [usize; 3],
        alpha: Option<usize>,
    },
    /// Luminance Y alone.
    Luminance { y: usize, alpha: Option<usize> },
    /// RY, Y and BY.
    Chroma {
        ry_y_by: [usize; 3],
        alpha: Option<usize>,
    },
}

impl Channels {
    /// The channels of red, green, blue and alpha.
    pub(super) fn indices(self) -> [Option<usize>; 4] {
        let (colors, alpha) = match self {
            Self::Rgb { rgb: c, alpha } | Self::Chroma { ry_y_by: c, alpha } => (c, alpha),
            Self::Luminance { y, alpha } => ([y; 3], alpha),
        };
        let [r, g, b] = colors.map(Some);
        [r, g, b, alpha]
    }

    /// The lower, the more it is what a file is usually read for.
    fn rank(self) -> u8 {
        match self {
            Self::Rgb { .. } => 0,
            Self::Chroma { .. } => 1,
            Self::Luminance { .. } => 2,
        }
    }
}

/// Colours in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layer {
    /// Which part of the file it lies in.
    pub(super) part: usize,
    pub(super) channels: Channels,
    /// What stands before its channels' names; empty where nothing does.
    prefix: String,
    /// The part's name, where it has one.
    part_name: Option<String>,
}

impl Layer {
    /// Names by which it can be asked for; the first is the one that messages use.
    fn names(&self) -> Vec<String> {
        let prefix = &self.prefix;
        match &self.part_name {
            Some(part) if prefix.is_empty() => vec![part.clone()],
            Some(part) if prefix != part => vec![prefix.clone(), format!("{part}.{prefix}")],
            _ => vec![prefix.clone()],
        }
    }
}

/// Last words of layers' names that stand for the whole image among further layers (Blender,
/// Arnold, Nuke).
const USUAL: [&str; 3] = ["combined", "beauty", "rgba"];

/// The layer called `name`; without one the channels R, G and B that no layer's name precedes, else
/// the only layer.
pub(super) fn choose(
    file: &Path,
    meta: &MetaData,
    name: Option<&str>,
    warnings: &mut Vec<String>,
) -> Result<Layer, InputError> {
    let all = all(meta);
    if let Some(name) = name {
        let mut named = all.iter().filter(|l| l.names().iter().any(|n| n == name));
        return named.next().cloned().ok_or_else(|| {
            let problem = format!("has no layer of colours called `{name}`");
            InputError::file(file, problem, expected(&all))
        });
    }
    let in_root = |layer: &&Layer| layer.prefix.is_empty();
    let root = all.iter().filter(in_root).min_by_key(|l| l.channels.rank());
    if let Some(layer) = root {
        return Ok(layer.clone());
    }
    let usual = |layer: &&Layer| {
        let last = layer.prefix.rsplit('.').next().unwrap_or_default();
        USUAL.contains(&last.to_ascii_lowercase().as_str())
    };
    let usual: Vec<&Layer> = all.iter().filter(usual).collect();
    let layer = match (&all[..], &usual[..]) {
        ([layer], _) => layer,
        (_, [layer]) => *layer,
        ([], _) => return Err(no_colors(file, meta)),
        _ => {
            let problem = "has several layers of colours and none without a name";
            return Err(InputError::file(file, problem, expected(&all)));
        }
    };
    warnings.push(format!(
        "{}: its layer `{}` is used",
        file.display(),
        layer.prefix
    ));
    Ok(layer.clone())
}

/// The error about a file in which nothing is a colour.
fn no_colors(file: &Path, meta: &MetaData) -> InputError {
    let expected = "channels R, G and B, or Y, in a flat image";
    if meta.headers.iter().all(|h| h.deep) {
        return InputError::file(file, "holds deep data alone", expected);
    }
    let channels = meta.headers.iter().flat_map(|h| &h.channels.list);
    let names: Vec<String> = channels.map(|c| c.name.to_string()).collect();
    let problem = format!("has no colours: its channels are {}", names.join(", "));
    InputError::file(file, problem, expected)
}

fn expected(all: &[Layer]) -> String {
    let names = all.iter().flat_map(|l| l.names().into_iter().take(1));
    let names: Vec<String> = names.filter(|n| !n.is_empty()).collect();
    if names.is_empty() {
        return "no `layer`: its colours belong to none".to_owned();
    }
    format!("`layer` to be one of {}", names.join(", "))
}

/// All colours of the flat parts of a file, in its order.
fn all(meta: &MetaData) -> Vec<Layer> {
    let flat = meta.headers.iter().enumerate().filter(|(_, h)| !h.deep);
    flat.flat_map(|(part, header)| of_part(part, header))
        .collect()
}

fn of_part(part: usize, header: &Header) -> Vec<Layer> {
    let names: Vec<String> = header
        .channels
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    let split = |name: &str| match name.rsplit_once('.') {
        Some((prefix, last)) => (prefix.to_owned(), last.to_owned()),
        None => (String::new(), name.to_owned()),
    };
    let names: Vec<(String, String)> = names.iter().map(|n| split(n)).collect();
    let mut prefixes: Vec<&String> = names.iter().map(|(prefix, _)| prefix).collect();
    prefixes.dedup();
    let part_name = header.own_attributes.layer_name.as_ref();
    let part_name = part_name.map(ToString::to_string).filter(|n| !n.is_empty());
    let layer = |prefix: &String| {
        let find = |wanted: &str| {
            let exact = |same: fn(&str, &str) -> bool| {
                let is = |(p, n): &(String, String)| p == prefix && same(n, wanted);
                names.iter().position(is)
            };
            exact(|a, b| a == b).or_else(|| exact(str::eq_ignore_ascii_case))
        };
        let three = |names: [&str; 3]| -> Option<[usize; 3]> {
            Some([find(names[0])?, find(names[1])?, find(names[2])?])
        };
        let alpha = find("A");
        let rgb = three(["R", "G", "B"]).map(|rgb| Channels::Rgb { rgb, alpha });
        let chroma = || three(["RY", "Y", "BY"]).map(|ry_y_by| Channels::Chroma { ry_y_by, alpha });
        let grey = || find("Y").map(|y| Channels::Luminance { y, alpha });
        let channels = rgb.or_else(chroma).or_else(grey)?;
        Some(Layer {
            part,
            channels,
            prefix: prefix.clone(),
            part_name: part_name.clone(),
        })
    };
    prefixes.into_iter().filter_map(layer).collect()
}
