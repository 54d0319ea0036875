//! The statements of an OBJ file, line by line.
//!
//! The crate `tobj`, which reads the material libraries, is not enough for these: it takes
//! polylines for faces, mixes up the attributes of faces that have them with those that do not, and
//! ends at a comment behind data, a continued line, a texture coordinate of one number or a text
//! that is not UTF-8.

use super::{NONE, ObjFile};
use crate::error::InputError;
use crate::scene::load::text;
use crate::scene::load::vertex_colors::Clamped;
use glam::{DVec2, DVec3, Vec4};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// Statements whose data may go on in the next line after a backslash, and end where a comment
/// begins. The others name something, which may contain both.
const DATA: [&str; 8] = ["v", "vt", "vn", "f", "fo", "l", "p", "s"];
/// Statements of free-form curves and surfaces.
const FREE_FORM: [&str; 16] = [
    "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
    "sp", "end", "con", "bsp",
];
/// Statements that change nothing of what is seen.
const SILENT: [&str; 9] = [
    "o",
    "g",
    "mg",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
];

/// What a statement is refused for, and what would be right.
struct Refusal {
    problem: Option<String>,
    expected: String,
}

fn expected(what: impl Into<String>) -> Refusal {
    Refusal {
        problem: None,
        expected: what.into(),
    }
}

/// Reads statements into an [`ObjFile`].
pub(super) struct Reader<'a> {
    path: &'a Path,
    file: ObjFile,
    material_indices: HashMap<String, usize>,
    /// Largest index so far of positions, texture coordinates and normals, and the line that names
    /// it.
    largest: [(u32, usize); 3],
    clamped: Clamped,
    lines: usize,
    points: usize,
    free_form: bool,
    smooth: bool,
    unknown: BTreeSet<String>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(path: &'a Path) -> Self {
        Self {
            path,
            file: ObjFile {
                name: path.display().to_string(),
                runs: vec![(0, None)],
                ..ObjFile::default()
            },
            material_indices: HashMap::new(),
            largest: [(0, 0); 3],
            clamped: Clamped::default(),
            lines: 0,
            points: 0,
            free_form: false,
            smooth: false,
            unknown: BTreeSet::new(),
        }
    }

    pub(super) fn read(&mut self, text: &str) -> Result<(), InputError> {
        let mut lines = (1..).zip(text::lines(text));
        while let Some((number, line)) = lines.next() {
            let keyword = line.split_whitespace().next().unwrap_or_default();
            let line = if DATA.contains(&keyword) {
                whole_statement(line, &mut lines)
            } else {
                Cow::Borrowed(line)
            };
            self.statement(number, &line).map_err(|refusal| {
                let problem = refusal
                    .problem
                    .unwrap_or_else(|| format!("is `{}`", line.trim()));
                let line = format!("line {number}");
                InputError::new(self.path, line, problem, refusal.expected)
            })?;
        }
        Ok(())
    }

    fn statement(&mut self, line: usize, text: &str) -> Result<(), Refusal> {
        let mut words = text.split_whitespace();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        let rest = || text.trim_start()[keyword.len()..].trim();
        match keyword {
            "v" => return self.position(words),
            "vt" => {
                let [u, v] = numbers_or(words, 1..=3, 0.0, "`vt` and one to three numbers")?;
                // The file's v points up.
                self.file.uvs.push(DVec2::new(u, 1.0 - v));
            }
            "vn" => {
                let normal = numbers_or(words, 3..=usize::MAX, 0.0, "`vn` and three numbers")?;
                self.file.normals.push(DVec3::from_array(normal));
            }
            "f" | "fo" => return self.face(line, words),
            "l" => self.lines += 1,
            "p" => self.points += 1,
            "s" => self.smooth |= !matches!(rest(), "" | "0" | "off" | "null"),
            "usemtl" => self.use_material(rest()),
            "mtllib" if rest().is_empty() => {}
            "mtllib" => self.file.libraries.push(rest().to_owned()),
            comment if comment.starts_with('#') => {}
            known if SILENT.contains(&known) => {}
            known if FREE_FORM.contains(&known) => self.free_form = true,
            unknown => {
                self.unknown.insert(unknown.chars().take(20).collect());
            }
        }
        Ok(())
    }

    fn position<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), Refusal> {
        let refused = || expected("`v` and three numbers, and three for a colour");
        let mut numbers = [0.0; 7];
        let mut count = 0;
        for word in words.take(numbers.len()) {
            let number = text::number(word);
            numbers[count] = number.ok_or_else(|| expected("`v` and three numbers"))?;
            count += 1;
        }
        let (position, color) = match numbers[..count] {
            [x, y, z] => (DVec3::new(x, y, z), None),
            [_, _, _, w] if w.abs() <= 0.0 => return Err(expected("a weight `w` other than 0")),
            [x, y, z, w] => (DVec3::new(x, y, z) / w, None),
            [x, y, z, r, g, b] => (DVec3::new(x, y, z), Some([r, g, b])),
            [] | [_] | [_, _] => return Err(expected("`v` and three numbers")),
            _ => return Err(refused()),
        };
        let before = self.file.positions.len();
        self.file.positions.push(position);
        let Some([r, g, b]) = color else {
            if !self.file.colors.is_empty() {
                self.file.colors.push(Vec4::ONE);
            }
            return Ok(());
        };
        let color = self.clamped.color([r, g, b, 1.0]).ok_or_else(refused)?;
        self.file.colors.resize(before, Vec4::ONE);
        self.file.colors.push(color);
        Ok(())
    }

    fn face<'w>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'w str>,
    ) -> Result<(), Refusal> {
        for word in words {
            let mut corner = [NONE; 3];
            for (which, index) in word.split('/').enumerate() {
                let place = corner.get_mut(which).ok_or_else(corners_expected)?;
                if !index.is_empty() {
                    *place = self.index(line, which, index)?;
                }
            }
            if corner[0] == NONE {
                return Err(corners_expected());
            }
            self.file.corners.push(corner);
        }
        let end = u32::try_from(self.file.corners.len());
        let end = end.map_err(|_| expected("fewer than 2³² corners"))?;
        self.file.ends.push(end);
        Ok(())
    }

    /// The position, texture coordinate or normal, as `which` says, that a face calls `index`, from 0.
    fn index(&mut self, line: usize, which: usize, index: &str) -> Result<u32, Refusal> {
        let given: i64 = index.parse().map_err(|_| corners_expected())?;
        let counts = self.counts();
        let from_zero = if given < 0 {
            i64::from(counts[which]) + given
        } else {
            given - 1
        };
        match u32::try_from(from_zero) {
            Ok(index) if index != NONE => {
                self.largest[which] = self.largest[which].max((index, line));
                Ok(index)
            }
            _ => {
                let (problem, expected) = out_of_range(which, &given.to_string(), counts[which]);
                let problem = Some(problem);
                Err(Refusal { problem, expected })
            }
        }
    }

    fn counts(&self) -> [u32; 3] {
        let ObjFile {
            positions,
            uvs,
            normals,
            ..
        } = &self.file;
        [positions.len(), uvs.len(), normals.len()].map(|n| u32::try_from(n).unwrap_or(NONE))
    }

    fn use_material(&mut self, name: &str) {
        let index = (!name.is_empty()).then(|| {
            let next = self.file.materials.len();
            let index = *self.material_indices.entry(name.to_owned()).or_insert(next);
            if index == next {
                self.file.materials.push(name.to_owned());
            }
            index
        });
        self.file.runs.push((self.file.ends.len(), index));
    }

    /// The file, once its faces are known to name what it has.
    pub(super) fn finish(mut self, warnings: &mut Vec<String>) -> Result<ObjFile, InputError> {
        let counts = self.counts();
        for (which, &(index, line)) in self.largest.iter().enumerate() {
            if line > 0 && index >= counts[which] {
                let given = (u64::from(index) + 1).to_string();
                let (problem, expected) = out_of_range(which, &given, counts[which]);
                let line = format!("line {line}");
                return Err(InputError::new(self.path, line, problem, expected));
            }
        }
        if !self.file.colors.is_empty() {
            self.file
                .colors
                .resize(self.file.positions.len(), Vec4::ONE);
        }
        self.warn(warnings);
        Ok(self.file)
    }

    fn warn(&self, warnings: &mut Vec<String>) {
        let name = &self.file.name;
        let mut warn = |sentence: String| warnings.push(format!("{name}: {sentence}"));
        let skipped = [(self.lines, "line"), (self.points, "point")];
        for (count, what) in skipped.into_iter().filter(|(count, _)| *count > 0) {
            let (s, are) = if count == 1 { ("", "is") } else { ("s", "are") };
            warn(format!("{count} {what} element{s} {are} not rendered"));
        }
        if self.free_form {
            warn("free-form curves and surfaces are not rendered".to_owned());
        }
        if self.smooth && self.file.normals.is_empty() {
            warn(
                "smoothing groups (s) are ignored: without vertex normals (vn) faces are flat"
                    .to_owned(),
            );
        }
        if !self.unknown.is_empty() {
            let unknown: Vec<&str> = self.unknown.iter().take(5).map(String::as_str).collect();
            let more = if self.unknown.len() > 5 { ", …" } else { "" };
            warn(format!(
                "unknown statements are ignored: {}{more}",
                unknown.join(", ")
            ));
        }
        if let Some(sentence) = self.clamped.sentence() {
            warn(sentence);
        }
    }
}

/// The statement that begins with `line`, without comments and joined with the lines in which it
/// goes on.
fn whole_statement<'t>(
    line: &'t str,
    rest: &mut impl Iterator<Item = (usize, &'t str)>,
) -> Cow<'t, str> {
    let continued = |line: &'t str| line.trim_end().strip_suffix('\\');
    let line = without_comment(line);
    let Some(start) = continued(line) else {
        return Cow::Borrowed(line);
    };
    let mut whole = start.to_owned();
    for (_, next) in rest.by_ref() {
        let next = without_comment(next);
        whole.push(' ');
        match continued(next) {
            Some(part) => whole.push_str(part),
            None => {
                whole.push_str(next);
                break;
            }
        }
    }
    Cow::Owned(whole)
}

/// What stands before a word that begins a comment. A number may contain a `#`, as in `-1.#IND`.
fn without_comment(line: &str) -> &str {
    let begins = |(at, _): &(usize, &str)| !line[..*at].ends_with('.');
    let comment = line.match_indices('#').find(begins);
    comment.map_or(line, |(at, _)| &line[..at])
}

fn corners_expected() -> Refusal {
    expected("`f` and indices such as 1, 1/2, 1//3 or 1/2/3")
}

/// The problem with an index, and what would be right, where there are `count`.
fn out_of_range(which: usize, given: &str, count: u32) -> (String, String) {
    let what = ["vertex", "texture coordinate", "normal"][which];
    let problem = format!("names {what} {given}, which is out of range");
    let expected = match count {
        0 => "no index: there is none".to_owned(),
        n => format!("1 to {n}, or -{n} to -1 (there are {n})"),
    };
    (problem, expected)
}

/// The first `N` numbers of as many as `allowed`, `missing` where there are fewer.
fn numbers_or<'w, const N: usize>(
    words: impl Iterator<Item = &'w str>,
    allowed: std::ops::RangeInclusive<usize>,
    missing: f64,
    what: &str,
) -> Result<[f64; N], Refusal> {
    let mut numbers = [missing; N];
    let mut count = 0;
    for word in words {
        let number = text::number(word).ok_or_else(|| expected(what))?;
        if let Some(place) = numbers.get_mut(count) {
            *place = number;
        }
        count += 1;
    }
    if allowed.contains(&count) {
        Ok(numbers)
    } else {
        Err(expected(what))
    }
}
