//! Renders a scene file to a picture and says how right it is:
//! `./lavapipe cargo run --release --example hello`

use direkt::{Error, LoadOptions, Renderer, Scene};

fn main() -> Result<(), Error> {
    let scene = Scene::load("scenes/cornell.toml", &LoadOptions::default())?;
    let image = Renderer::new()?.render(scene)?;
    image.write("hello.png")?;
    let error = image.error().map_or(f64::NAN, |e| e.nmse.percent()[0]);
    println!("hello.png: √NMSE {error:.2} %");
    Ok(())
}
