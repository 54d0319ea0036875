//! What can go wrong, and whose fault it is.
//!
//! The policy: an [`Error`] is about input or the machine and names what would be right; a broken
//! invariant of direkt itself is an `assert!` with a message.

use std::path::{Path, PathBuf};

/// The environment variable that names a folder from which shaders are read instead of those in the
/// binary; what is wrong with them is then the user's to mend.
pub const SHADERS_VARIABLE: &str = "DIREKT_SHADERS";

/// Everything a direkt command can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file, or a field in it, is not what it has to be.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The command was used wrongly, or two settings contradict each other.
    #[error("{0}")]
    Usage(String),
    /// A file could not be written.
    #[error("{}: cannot be written: {source}{}", path.display(), elsewhere(saved_as.as_deref()))]
    Write {
        /// The file that was meant to be written.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
        /// Where the same bytes were written instead.
        saved_as: Option<PathBuf>,
    },
    /// The GPU, its driver or its limits stand in the way.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl Error {
    /// A file that could not be written, and was written nowhere else.
    pub fn write(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Write {
            path: path.as_ref().to_path_buf(),
            source,
            saved_as: None,
        }
    }

    /// The process exit code: 2 for wrong use or bad input, 1 for everything else.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) | Self::Usage(_) => 2,
            Self::Gpu(e) if e.is_about_the_request() => 2,
            Self::Write { .. } | Self::Gpu(_) => 1,
        }
    }
}

fn elsewhere(saved_as: Option<&Path>) -> String {
    saved_as.map_or_else(String::new, |path| format!("; saved as {}", path.display()))
}

/// Bad input: which file, which field of it, what is wrong there and what would be right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file that holds the problem.
    pub file: PathBuf,
    /// Path of the field inside the file (`shapes[3].radius`), empty when the file as a whole is
    /// meant.
    pub field: String,
    /// What is wrong, with the value that was found.
    pub problem: String,
    /// What would be right; empty when the problem says it already.
    pub expected: String,
}

impl InputError {
    /// A problem with `field` of `file`.
    pub fn new(
        file: impl AsRef<Path>,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            file: file.as_ref().to_path_buf(),
            field: field.into(),
            problem: problem.into(),
            expected: expected.into(),
        }
    }

    /// A problem with the file as a whole.
    pub fn file(
        file: impl AsRef<Path>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::new(file, "", problem, expected)
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: ", self.file.display())?;
        if !self.field.is_empty() {
            write!(f, "{}: ", readable(&self.field))?;
        }
        write!(f, "{}", readable(&self.problem))?;
        if !self.expected.is_empty() {
            write!(f, "; expected {}", readable(&self.expected))?;
        }
        Ok(())
    }
}

/// `text`, which may quote a stranger's file, fit for a terminal: control characters are escaped,
/// numbers of many digits are written with a power of ten, and of what is long the middle is left
/// out.
pub fn readable(text: &str) -> String {
    const MAX_CHARS: usize = 400;
    let mut plain = String::with_capacity(text.len());
    for c in with_powers_of_ten(text).chars() {
        if c.is_control() {
            plain.extend(c.escape_default());
        } else {
            plain.push(c);
        }
    }
    let length = plain.chars().count();
    if length <= MAX_CHARS {
        return plain;
    }
    let head = plain.chars().take(MAX_CHARS * 3 / 4);
    let tail = plain.chars().skip(length - MAX_CHARS / 4);
    head.chain(" … ".chars()).chain(tail).collect()
}

/// `x` as people write it.
pub fn number(x: f64) -> String {
    with_powers_of_ten(&x.to_string())
}

/// `text` with `1e300` in place of a 1 and 300 zeros, which is how Rust writes that number. What is
/// quoted stays.
fn with_powers_of_ten(text: &str) -> String {
    /// More digits than any number has that is written without a power.
    const MANY: usize = 22;
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let (mut out, mut rest, mut quoted) = (String::with_capacity(text.len()), text, false);
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        let (numeral, after) = rest.split_at(end);
        let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let stands_alone = !is_word(out.chars().last()) && !is_word(after.chars().next());
        match numeral.parse::<f64>() {
            Ok(number) if end > MANY && !quoted && stands_alone => {
                out += &format!("{number:e}");
            }
            _ if end > 0 => out += numeral,
            _ => {
                quoted ^= first == '`';
                out.push(first);
                rest = &rest[first.len_utf8()..];
                continue;
            }
        }
        rest = after;
    }
    out
}

impl std::error::Error for InputError {}

/// The GPU, its driver or its limits stand in the way.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all.
    #[error(
        "no GPU adapter found: install a Vulkan driver, or run `./lavapipe direkt …`, which installs Mesa lavapipe (Vulkan in software)"
    )]
    NoAdapter,
    /// No adapter's name contains what `--adapter` asked for.
    #[error("no adapter's name contains `{wanted}`; there are: {}", available.join(", "))]
    NoSuchAdapter {
        /// The substring that was asked for.
        wanted: String,
        /// Names of the adapters that exist.
        available: Vec<String>,
    },
    /// The scene needs more than the adapter offers.
    #[error("{what} needs {needed} bytes, but {adapter} binds at most {limit} bytes in one buffer")]
    TooLarge {
        /// The buffer, in words.
        what: String,
        /// Bytes that the scene needs.
        needed: u64,
        /// The adapter's `max_storage_buffer_binding_size`.
        limit: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// The scene has more of something than the adapter allows.
    #[error("there are {needed} {what}, but {adapter} allows {limit}")]
    TooMany {
        /// What there is too much of.
        what: String,
        /// How many the scene needs.
        needed: u64,
        /// The adapter's limit.
        limit: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// The machine has less memory than the image takes.
    #[error(
        "{what} takes {needed} bytes of memory, but {available} are available; a smaller image, or a machine or limit with more memory, is needed"
    )]
    TooLittleMemory {
        /// What takes it, in words.
        what: String,
        /// Bytes that it takes.
        needed: u64,
        /// Bytes that this process may still take.
        available: u64,
    },
    /// The device could not be opened.
    #[error("{adapter}: the device could not be opened: {message}")]
    Device {
        /// The adapter's name.
        adapter: String,
        /// What wgpu said.
        message: String,
    },
    /// A shader could not be linked or compiled: direkt's own fault, or that of `DIREKT_SHADERS`.
    #[error("shader `{entry}`: {message}")]
    Shader {
        /// The entry module, e.g. `kernel/direct`.
        entry: String,
        /// What the linker or compiler said.
        message: String,
    },
    /// The device was lost: its driver crashed or was replaced, its watchdog bit, or it was
    /// unplugged.
    #[error("{adapter}: the device was lost: {message}")]
    Lost {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        message: String,
    },
    /// The adapter ran out of memory.
    #[error(
        "{adapter}: out of memory: {message}; a smaller image or scene, or an adapter with more memory, is needed"
    )]
    OutOfMemory {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        message: String,
    },
    /// The driver reported an error.
    #[error("{adapter}: {message}")]
    Driver {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        message: String,
    },
}

impl GpuError {
    /// Whether the user asked for something this machine does not have, or brought shaders that are
    /// wrong (exit code 2).
    fn is_about_the_request(&self) -> bool {
        match self {
            Self::NoAdapter
            | Self::NoSuchAdapter { .. }
            | Self::TooLarge { .. }
            | Self::TooMany { .. }
            | Self::TooLittleMemory { .. } => true,
            Self::Shader { .. } => std::env::var_os(SHADERS_VARIABLE).is_some(),
            Self::Device { .. }
            | Self::Lost { .. }
            | Self::OutOfMemory { .. }
            | Self::Driver { .. } => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_many_digits_have_powers_of_ten() {
        let (huge, tiny) = (1e300, -2.5e-30);
        assert_eq!(readable(&format!("is {huge}")), "is 1e300");
        assert_eq!(readable(&format!("({tiny}, {huge})")), "(-2.5e-30, 1e300)");
        assert_eq!([number(-1e300), number(0.0)], ["-1e300", "0"]);
        let kept = [
            "is 0.1, 16777216 and 12345678901234567890".to_owned(),
            format!("`{huge}.png` does not exist"),
            format!("hash_{huge}"),
            "1.2.3".to_owned() + &"4".repeat(30),
        ];
        for text in kept {
            assert_eq!(readable(&text), text);
        }
    }
}
