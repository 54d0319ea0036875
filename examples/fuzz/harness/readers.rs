//! The readers under test: their valid inputs, how those are damaged, and how one is read.

use super::random::Random;
use super::{json, mutate, numbers, seeds, sound};
use direkt::error::Error;
use direkt::scene::Scene;
use direkt::scene::load::{LoadOptions, load};
use direkt::scene::validate::validate;
use std::path::{Path, PathBuf};

/// A reader of input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reader {
    /// Scenes in TOML, damaged in any way.
    Toml,
    /// Scenes in TOML whose numbers are others.
    Numbers,
    /// glTF with its data in the JSON.
    Gltf,
    /// glTF in one binary file.
    Glb,
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Radiance maps.
    Hdr,
    /// OpenEXR maps.
    Exr,
    /// `validate`, with scenes that are made in memory: an input names numbers of a valid one and
    /// what they become.
    Validate,
}

impl Reader {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Toml => "toml",
            Self::Numbers => "numbers",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Hdr => "hdr",
            Self::Exr => "exr",
            Self::Validate => "validate",
        }
    }

    /// The extension of its inputs.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Numbers => "toml",
            Self::Validate => "txt",
            other => other.name(),
        }
    }

    /// Valid inputs.
    pub fn seeds(self) -> Vec<Vec<u8>> {
        match self {
            Self::Toml | Self::Numbers => [seeds::TOML, seeds::TOML_OF_FILES]
                .map(|text| text.as_bytes().to_vec())
                .to_vec(),
            Self::Gltf => vec![seeds::gltf().to_string().into_bytes()],
            Self::Glb => vec![seeds::binary_gltf()],
            Self::Ply => seeds::ply(),
            Self::Obj => seeds::obj(),
            Self::Hdr => seeds::hdr(),
            Self::Exr => seeds::exr(),
            Self::Validate => vec![Vec::new()],
        }
    }

    /// Input `chosen` of `pool`, damaged.
    pub fn mutated(self, random: &mut Random, chosen: usize, pool: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = pool[chosen].clone();
        for _ in 0..random.few() {
            match self {
                Self::Numbers => mutate::replace_number(random, &mut bytes),
                Self::Validate => {
                    let number = random.one_of(&mutate::NUMBERS);
                    bytes.extend(format!("{} {number}\n", random.below(400)).bytes());
                }
                Self::Gltf | Self::Glb if random.below(4) > 0 => {
                    self.damage_json(random, &mut bytes)
                }
                _ => mutate::damage(random, &mut bytes, pool, self.words()),
            }
        }
        bytes.truncate(mutate::MAX_BYTES);
        bytes
    }

    fn damage_json(self, random: &mut Random, bytes: &mut Vec<u8>) {
        let Some((mut root, bin)) = json::parts(bytes) else {
            return mutate::damage(random, bytes, &[seeds::binary_gltf()], self.words());
        };
        json::damage(random, &mut root, self.words());
        *bytes = match self {
            Self::Glb => json::glb(&root, bin),
            _ => root.to_string().into_bytes(),
        };
    }

    /// What may stand in its inputs and means something.
    fn words(self) -> &'static [&'static str] {
        match self {
            Self::Toml | Self::Numbers => &[
                "[[",
                "]]",
                "shapes",
                "mesh",
                "file",
                "part.glb",
                "mesh.ply",
                "map.exr",
                "scale",
                "matrix",
                "look_at",
                "rotate",
                "radiance",
                "light",
                "material",
                "true",
                "inline",
                "point",
                "pixels",
                "\"\\u0000\"",
                "'''",
                "1979-05-27T07:32:00Z",
                "../input.toml",
                "input.toml",
            ],
            Self::Gltf | Self::Glb => &[
                "VEC3",
                "SCALAR",
                "MAT4",
                "POSITION",
                "NORMAL",
                "sparse",
                "perspective",
                "orthographic",
                "spot",
                "point",
                "directional",
                "../a.bin",
                "part.glb",
                "data:;base64,AAAA",
                "data:,",
                "%00",
                "2.0",
                "https://a",
                "KHR_mesh_quantization",
                "",
                "BLEND",
            ],
            Self::Ply => &[
                "element",
                "property",
                "list",
                "vertex",
                "face",
                "char",
                "uchar",
                "short",
                "ushort",
                "int",
                "uint",
                "float",
                "double",
                "vertex_index",
                "x",
                "end_header",
                "ascii",
                "binary_little_endian",
                "binary_big_endian",
                "obj_info",
                "comment",
                "int8",
                "float64",
                "\r",
            ],
            Self::Obj => &[
                "v", "vt", "vn", "f", "l", "p", "o", "g", "s", "usemtl", "mtllib", "/", "//", "\\",
                "-1",
            ],
            Self::Hdr => &[
                "#?RADIANCE",
                "#?RGBE",
                "FORMAT=32-bit_rle_xyze",
                "-Y",
                "+Y",
                "+X",
                "-X",
                "COLORCORR=1 1 1",
            ],
            Self::Exr => &[
                "channels",
                "chlist",
                "compression",
                "dataWindow",
                "displayWindow",
                "tiles",
                "R",
                "A",
                "Y",
            ],
            Self::Validate => &[],
        }
    }
}

/// A folder in memory where there is one, with the files that the inputs name.
#[derive(Debug)]
pub struct Workplace {
    folder: tempfile::TempDir,
    reader: Reader,
    valid: Option<Scene>,
}

impl Workplace {
    /// A place for inputs of `reader`.
    pub fn new(reader: Reader) -> std::io::Result<Self> {
        let memory = Path::new("/dev/shm");
        let folder =
            tempfile::Builder::new()
                .prefix("direkt-fuzz-")
                .tempdir_in(if memory.is_dir() {
                    memory.to_path_buf()
                } else {
                    std::env::temp_dir()
                })?;
        let mut place = Self {
            folder,
            reader,
            valid: None,
        };
        let [ascii, ..] = &seeds::ply()[..] else {
            unreachable!("there are three")
        };
        place.write("mesh.ply", ascii)?;
        place.write("mesh.obj", &seeds::obj()[1])?;
        place.write("map.hdr", &seeds::hdr()[0])?;
        place.write("map.exr", &seeds::exr()[0])?;
        place.write("part.glb", &seeds::binary_gltf())?;
        let shape = |file: &str| format!("[[shapes]]\ntype = \"mesh\"\nfile = \"{file}\"\n");
        let map = |file: &str| format!("[environment]\nfile = \"{file}\"\n");
        let scene = match reader {
            Reader::Ply => shape("input.ply"),
            Reader::Obj => shape("input.obj"),
            Reader::Hdr => map("input.hdr"),
            Reader::Exr => map("input.exr"),
            _ => format!(
                "{}{}",
                seeds::TOML,
                &seeds::TOML_OF_FILES[seeds::TOML_OF_FILES.find("[[lights]]").unwrap_or(0)..]
                    .split("[environment]")
                    .next()
                    .unwrap_or("")
            ),
        };
        place.write("scene.toml", scene.as_bytes())?;
        if reader == Reader::Validate {
            let scene = load(&place.path("scene.toml"), &LoadOptions::default());
            place.valid = Some(scene.map_err(std::io::Error::other)?);
        }
        Ok(place)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        std::fs::write(self.path(name), bytes)
    }

    /// The file that holds the input at hand, also after a crash.
    pub fn input(&self) -> PathBuf {
        self.path("input").with_extension(self.reader.extension())
    }

    /// Puts an input in its place.
    pub fn put(&self, bytes: &[u8]) -> std::io::Result<()> {
        std::fs::write(self.input(), bytes)
    }

    /// Reads the input that was put in place, `bytes`: the message with which it is refused, or
    /// `None`. `Err` says what is wrong with the reader.
    pub fn read(&self, bytes: &[u8]) -> Result<Option<String>, String> {
        let read = match self.reader {
            Reader::Toml | Reader::Numbers | Reader::Gltf | Reader::Glb => {
                load(&self.input(), &LoadOptions::default())
            }
            Reader::Ply | Reader::Obj | Reader::Hdr | Reader::Exr => {
                load(&self.path("scene.toml"), &LoadOptions::default())
            }
            Reader::Validate => self.altered(bytes),
        };
        match read {
            Ok(scene) => {
                let broken = scene.warnings.iter().find(|w| !is_readable(w));
                broken.map_or(Ok(()), |w| {
                    Err(format!("its warning is not one line: {w:?}"))
                })?;
                sound::check(scene).map(|()| None)
            }
            Err(error) => self.refusal(&error).map(Some),
        }
    }

    /// The valid scene with other numbers, validated.
    fn altered(&self, bytes: &[u8]) -> Result<Scene, Error> {
        let text = String::from_utf8_lossy(bytes);
        let changes: Vec<(usize, f64)> = text
            .lines()
            .filter_map(|line| {
                let (index, number) = line.split_once(' ')?;
                Some((index.parse().ok()?, number.parse().ok()?))
            })
            .collect();
        let mut scene = self
            .valid
            .clone()
            .ok_or_else(|| Error::Usage("no valid scene".to_owned()))?;
        let mut index = 0;
        numbers::visit(&mut scene, &mut |number| {
            let change = changes.iter().rfind(|(at, _)| *at == index);
            index += 1;
            change.map_or(number, |(_, new)| *new)
        });
        validate(&scene).map(|()| scene)
    }

    /// A refusal is one line, not long, about a file of the folder, and ends with exit code 2.
    fn refusal(&self, error: &Error) -> Result<String, String> {
        let message = error.to_string();
        let folder = self.folder.path().display().to_string();
        let of_input = message.starts_with(&folder) && error.exit_code() == 2;
        if of_input && is_readable(&message) {
            Ok(message.replace(&folder, "DIR"))
        } else {
            Err(format!(
                "its message is not one line about its file: {message:?}"
            ))
        }
    }
}

/// Whether a terminal shows it as one line, not long.
fn is_readable(message: &str) -> bool {
    message.len() < 4000 && !message.contains(char::is_control)
}
