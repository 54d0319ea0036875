//! `render --watch` and `--tev`: a render in progress, shown elsewhere.

use super::{run, text};
use exr::prelude::read_first_flat_layer_from_file;
use std::io::Read;
use std::net::TcpListener;
use std::process::Command;
use std::time::{Duration, Instant};

const SIZE: &str = "48x32";
const PIXELS: usize = 48 * 32;
/// Numbers of tev's packets.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

#[test]
fn outputs_are_written_while_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("out.png");
    let mut child = Command::new(env!("CARGO_BIN_EXE_direkt"))
        .args(["render", "scenes/cornell.toml", "-q", "--size", SIZE])
        .args(["--time", "4", "--watch=0.1", "-o", text(&png)])
        .current_dir(crate::support::PROJECT)
        .spawn()
        .unwrap();
    let mut images = Vec::new();
    let end = Instant::now() + Duration::from_secs(120);
    while child.try_wait().unwrap().is_none() {
        assert!(Instant::now() < end, "--time ends it");
        // What is there is always a whole image.
        if png.exists() {
            images.push(image::open(&png).unwrap().into_rgb8());
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    images.dedup();
    assert!(images.len() > 2, "{} images on the way", images.len());
    let (code, _, said) = run(&[
        "render",
        "scenes/cornell.toml",
        "-o",
        text(&png),
        "--watch=0",
    ]);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("--watch=0: a positive number"), "{said}");
}

/// Type and content of the next packet; none at the end.
fn packet(from: &mut impl Read) -> Option<(u8, Vec<u8>)> {
    let mut length = [0; 4];
    from.read_exact(&mut length).ok()?;
    let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
    from.read_exact(&mut bytes).unwrap();
    Some((bytes[0], bytes.split_off(1)))
}

#[test]
fn tev_is_sent_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("out.exr");
    let tev = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = tev.local_addr().unwrap().to_string();
    let receiving = std::thread::spawn(move || {
        let mut socket = tev.accept().unwrap().0;
        std::iter::from_fn(|| packet(&mut socket)).collect::<Vec<_>>()
    });
    let (code, _, said) = run(&[
        "render",
        "scenes/cornell.toml",
        "--size",
        SIZE,
        "--spp",
        "16",
        "--tev",
        &address,
        "-o",
        text(&exr),
    ]);
    assert_eq!(code, 0, "{said}");
    let packets = receiving.join().unwrap();
    let kinds: Vec<u8> = packets.iter().map(|p| p.0).collect();
    assert_eq!(kinds[0], CREATE_IMAGE);
    assert!(kinds.len() > 1 && kinds[1..].iter().all(|&k| k == UPDATE_IMAGE));
    let created = String::from_utf8_lossy(&packets[0].1);
    assert!(created.contains("direkt: scenes/cornell.toml"), "{created}");
    let last = &packets[packets.len() - 1].1;
    let values = last[last.len() - 4 * 3 * PIXELS..].chunks_exact(4);
    let sent: Vec<f32> = values
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect();
    let layer = read_first_flat_layer_from_file(&exr).unwrap().layer_data;
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let channel = layer.channel_data.list.iter();
        let channel = channel.clone().find(|ch| ch.name.to_string() == name);
        let saved: Vec<f32> = channel.unwrap().sample_data.values_as_f32().collect();
        let sent: Vec<f32> = sent.iter().skip(c).step_by(3).copied().collect();
        assert_eq!(sent, saved, "{name}");
    }
}

#[test]
fn nobody_listening_is_said_before_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("out.png");
    // A port that was free a moment ago.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr();
    let address = address.unwrap().to_string();
    let arguments = ["render", "scenes/cornell.toml", "-o", text(&png), "--tev"];
    let (code, _, said) = run(&[&arguments[..], &[address.as_str()]].concat());
    assert_eq!(code, 2, "{said}");
    assert!(said.contains(&format!("--tev {address}")) && said.contains("start tev first"));
    assert!(!png.exists());
}
