//! Writes scenes that nobody chose, named by their seeds:
//! `cargo run --release --example random_scenes -- FOLDER [COUNT [FIRST]]`, and then
//! `direkt cost FOLDER/*.toml --calibrate` to see whether the errors that their images state hold.

mod generator;
#[path = "../fuzz/harness/random.rs"]
mod random;
mod textures;

use direkt::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let usage = || Error::Usage("expected FOLDER [COUNT [FIRST]], such as `random 100`".to_owned());
    let folder = PathBuf::from(arguments.next().ok_or_else(usage)?);
    let mut number = |otherwise: u64| match arguments.next() {
        Some(text) => text.parse::<u64>().map_err(|_| usage()),
        None => Ok(otherwise),
    };
    let (count, first) = (number(100)?, number(1)?);
    std::fs::create_dir_all(&folder).map_err(|e| failed(&folder, &e))?;
    for (name, bytes) in textures::files() {
        write(&folder.join(name), &bytes)?;
    }
    for seed in first..first + count {
        let path = folder.join(format!("{seed:04}.toml"));
        write(&path, generator::scene(seed).as_bytes())?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    std::fs::write(path, bytes).map_err(|e| failed(path, &e))
}

fn failed(path: &Path, error: &std::io::Error) -> Error {
    Error::Usage(format!("{}: {error}", path.display()))
}
