//! Which strategy is worth its time on a scene: error at equal samples, time, and efficiency
//! 1/(relMSE · s).

use direkt::{Error, LoadOptions, Renderer, Scene, Strategy};
use std::time::Instant;

fn main() -> Result<(), Error> {
    let renderer = Renderer::new()?;
    println!(
        "{:<26} {:>9} {:>8} {:>12}",
        "strategy", "√relMSE", "seconds", "efficiency"
    );
    for strategy in [
        Strategy::CosineHemisphere,
        Strategy::Bsdf,
        Strategy::LightArea,
        Strategy::LightSolidAngle,
        Strategy::MisPower,
    ] {
        let mut scene = Scene::load("scenes/veach.toml", &LoadOptions::default())?;
        (scene.film.width, scene.film.height) = (192, 128);
        (scene.render.estimator.strategy, scene.render.stop.spp) = (strategy, 64);
        // The kernel is compiled in a render of its own: that is no part of the rendering.
        let mut first = scene.clone();
        first.render.stop.spp = 1;
        renderer.render(first)?;
        let start = Instant::now();
        let image = renderer.render(scene)?;
        let seconds = start.elapsed().as_secs_f64();
        let Some(error) = image.error() else {
            println!("{:<26} no light found", strategy.to_string());
            continue;
        };
        let efficiency = 1.0 / (error.rel_mse.value * seconds);
        let percent = error.rel_mse.percent()[0];
        println!(
            "{:<26} {percent:>7.2} % {seconds:>8.2} {efficiency:>12.0}",
            strategy.to_string()
        );
    }
    Ok(())
}
