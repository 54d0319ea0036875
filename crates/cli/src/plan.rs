//! What a command is going to write: refused before it computes anything where that could not be
//! done, or would destroy something.

use direkt::error::Error;
use direkt::low_level::console::say;
use direkt::low_level::image::extension;
use direkt::low_level::output::{self, Destination, Identity};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The outputs of a command, and the files that it reads.
#[derive(Debug, Default)]
pub struct Plan {
    outputs: Vec<Planned>,
    inputs: Vec<Identity>,
}

#[derive(Debug)]
struct Planned {
    /// As the user named it, with the flag.
    name: String,
    identity: Identity,
}

impl Plan {
    /// Adds an image, which is an .exr or a .png.
    ///
    /// # Errors
    /// It could not be written, or another output is the same file.
    pub fn image(&mut self, flag: &str, path: &Path) -> Result<(), Error> {
        if !matches!(extension(path).as_str(), "exr" | "png") {
            return refuse(flag, path, "an image file ends in .exr or .png");
        }
        match self.file(flag, path)? {
            Destination::File(_) => Ok(()),
            _ => refuse(flag, path, "is a pipe or a device; an image needs a file"),
        }
    }

    /// Adds a file.
    ///
    /// # Errors
    /// It could not be written, or another output is the same file.
    pub fn file(&mut self, flag: &str, path: &Path) -> Result<Destination, Error> {
        let destination = output::probe(path).or_else(|reason| refuse(flag, path, &reason))?;
        self.claim(flag, path)?;
        Ok(destination)
    }

    /// Adds a folder, which is made if need be, and the files `names` in it.
    ///
    /// # Errors
    /// They could not be written, or another output is one of these files.
    pub fn folder(&mut self, flag: &str, folder: &Path, names: &[String]) -> Result<(), Error> {
        if folder.exists() && !folder.is_dir() {
            return refuse(flag, folder, "is a file; name a folder");
        }
        if let Err(error) = std::fs::create_dir_all(folder) {
            let reason = format!("the folder cannot be made: {error}");
            return refuse(flag, folder, &reason);
        }
        output::probe_folder(folder).or_else(|(_, reason)| refuse(flag, folder, &reason))?;
        for name in names {
            let path = folder.join(name);
            Destination::of(&path).or_else(|reason| refuse(flag, &path, &reason))?;
            self.claim(flag, &path)?;
        }
        Ok(())
    }

    /// Keeps the other outputs from having names that end in `extension` in `folder`, where files
    /// of names not known yet are written.
    ///
    /// # Errors
    /// One of them has such a name.
    pub fn reserve(&self, folder: &Path, ending: &str) -> Result<(), Error> {
        let folder = folder.canonicalize().ok();
        let is_there = |output: &&Planned| output.identity.folder() == folder.as_deref();
        let mut there = self.outputs.iter().filter(is_there);
        match there.find(|output| extension(output.identity.path()) == ending) {
            None => Ok(()),
            Some(Planned { name, .. }) => Err(Error::Usage(format!(
                "{name}: files that end in .{ending} are written there; name another"
            ))),
        }
    }

    fn claim(&mut self, flag: &str, path: &Path) -> Result<(), Error> {
        let Some(identity) = Identity::of(path) else {
            return Ok(());
        };
        let mut others = self.outputs.iter();
        if let Some(other) = others.find(|other| other.identity.is_same(&identity)) {
            let reason = format!("is the same file as {}; name another", other.name);
            return refuse(flag, path, &reason);
        }
        let name = format!("{flag} {}", path.display());
        self.outputs.push(Planned { name, identity });
        Ok(())
    }

    /// Keeps the files `inputs`, which are read as `what` says ("the scene itself"), from being
    /// written.
    ///
    /// # Errors
    /// One of them is an output.
    pub fn spare<'a>(
        &mut self,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
        what: &str,
    ) -> Result<(), Error> {
        for identity in inputs.into_iter().filter_map(|path| Identity::of(path)) {
            if let Some(output) = self.outputs.iter().find(|o| o.identity.is_same(&identity)) {
                let name = &output.name;
                return Err(Error::Usage(format!(
                    "{name}: is {what}; name another file"
                )));
            }
            self.inputs.push(identity);
        }
        Ok(())
    }

    /// Writes `bytes` to `path`, or saves them elsewhere.
    ///
    /// # Errors
    /// They could not be written to `path`; the error names where they are saved.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        let is_input = |identity: Identity| self.inputs.iter().any(|i| i.is_same(&identity));
        if Identity::of(path).is_some_and(is_input) {
            let source = std::io::Error::other("it is one of the files that were read");
            return Err(Error::Write {
                path: path.to_path_buf(),
                source,
                saved_as: output::save_elsewhere(path, bytes),
            });
        }
        output::write_or_save_elsewhere(path, bytes)
    }
}

/// `folder`, made again where it has gone; where it takes no files any more, a new one elsewhere,
/// which is reported.
pub fn usable(folder: PathBuf, failures: &mut Failures) -> PathBuf {
    let made = std::fs::create_dir_all(&folder);
    let probed = made.and_then(|()| {
        let probed = output::probe_folder(&folder);
        probed.map_err(|(kind, reason)| std::io::Error::new(kind, reason))
    });
    let Err(source) = probed else {
        return folder;
    };
    let saved_as = output::rescue_folder(&folder);
    failures.note(Err(Error::Write {
        path: folder.clone(),
        source,
        saved_as: saved_as.clone(),
    }));
    saved_as.unwrap_or(folder)
}

fn refuse<T>(flag: &str, path: &Path, reason: &str) -> Result<T, Error> {
    let path = path.display();
    Err(Error::Usage(format!("{flag} {path}: {reason}")))
}

/// What went wrong although the command went on, as the exit code that the worst of it calls for.
#[derive(Debug, Default)]
pub struct Failures(u8);

impl Failures {
    /// Reports the error of `result`, if it is one; whether it is none.
    pub fn note(&mut self, result: Result<(), Error>) -> bool {
        if let Err(error) = &result {
            say(format_args!("direkt: {error}"));
            self.0 = self.0.max(error.exit_code());
        }
        result.is_ok()
    }

    /// The exit code of a command that would have ended with `code`.
    pub fn exit_code(&self, code: ExitCode) -> ExitCode {
        match self.0 {
            0 => code,
            failed => ExitCode::from(failed),
        }
    }
}
