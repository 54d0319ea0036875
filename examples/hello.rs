//! Renders a scene file to a picture and says how right it is:
//! `./lavapipe cargo run --release --example hello`

use direkt::{Error, LoadOptions, Renderer, Scene};

fn main() -> Result<(), Error> {
    let scene = Scene::load("scenes/cornell.toml", &LoadOptions::default())?;
    let image = Renderer::new()?.render(scene)?;
    image.write("hello.png")?;
    let error = image.error().map_or(f64::NAN, |e| 100.0 * e.rel_mse.sqrt());
    println!("hello.png: relative error {error:.2} %");
    Ok(())
}
