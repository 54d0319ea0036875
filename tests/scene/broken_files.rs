//! A corpus of broken files of every format, and what is said about each.

use super::files::Folder;
use crate::support::project;
use std::path::{Path, PathBuf};

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of the project");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

/// What is said about a file; meshes and maps are named by a scene.
fn message(file: &Path, format: &str) -> String {
    let folder = Folder::new();
    let name = file.file_name().unwrap().to_str().expect("an ASCII name");
    folder.write(name, std::fs::read(file).unwrap());
    let scene = match format {
        "ply" | "obj" => format!("[[shapes]]\ntype = \"mesh\"\nfile = \"{name}\"\n"),
        "hdr" | "exr" => format!("[environment]\nfile = \"{name}\"\n"),
        _ => return folder.load(name).expect_err(name),
    };
    folder.write("scene.toml", scene);
    folder.load("scene.toml").expect_err(name)
}

#[test]
fn broken_files_are_refused_in_these_words() {
    let mut messages = String::new();
    for folder in entries(&project("tests/data/broken")) {
        let format = folder.file_name().unwrap().to_str().expect("a format");
        let files = entries(&folder);
        assert!(files.len() >= 6, "{format}: {}", files.len());
        for file in files {
            messages += &format!("{}\n", message(&file, format));
        }
    }
    insta::assert_snapshot!(messages);
}
