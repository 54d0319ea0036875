//! Makes the pictures of README.md:
//! `./lavapipe cargo run --release --example gallery [FOLDER [SPP]]`

use direkt::{Error, LoadOptions, Renderer, Scene};
use std::path::PathBuf;

/// Scenes of `scenes/`, in the order of the page.
const SCENES: [&str; 9] = [
    "cornell",
    "glass",
    "depth_of_field",
    "spot_and_sun",
    "leaves",
    "textures",
    "sun",
    "window",
    "isometric",
];
/// Pixels per row.
const WIDTH: u32 = 280;

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or("docs/images/gallery".to_owned()));
    let spp = arguments.next().map_or(Ok(256), |spp| spp.parse());
    let spp = spp.map_err(|e| Error::Usage(format!("SPP: {e}; expected a number such as 256")))?;
    let cannot_make = |e| Error::Usage(format!("{}: {e}", folder.display()));
    std::fs::create_dir_all(&folder).map_err(cannot_make)?;
    let renderer = Renderer::new()?;
    for name in SCENES {
        let mut scene = Scene::load(format!("scenes/{name}.toml"), &LoadOptions::default())?;
        let film = &mut scene.film;
        (film.width, film.height) = (WIDTH, WIDTH * film.height / film.width);
        scene.render.stop.spp = spp;
        let image = renderer.render(scene)?;
        let path = folder.join(format!("{name}.png"));
        image.write(&path)?;
        let error = image.error().map_or(f64::NAN, |e| e.rel_mse.percent()[0]);
        println!("{}: relative error {error:.2} %", path.display());
    }
    Ok(())
}
