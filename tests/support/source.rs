//! The project's own source files, for tests of its structure.

use std::path::{Path, PathBuf};

/// Files in `folder` and below whose names end in one of `extensions`.
pub fn source_files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    let (folders, mut files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    files.retain(|path| {
        path.extension()
            .is_some_and(|e| extensions.iter().any(|wanted| e == *wanted))
    });
    files.extend(
        folders
            .iter()
            .flat_map(|folder| source_files(folder, extensions)),
    );
    files
}

/// `text` without comments and its own unit tests, which end a file.
pub fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}
