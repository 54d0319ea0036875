//! What is known of one pixel.

use super::row::row;
use crate::app::App;
use crate::density::CELLS;
use crate::picture::{Inspected, Picture};
use direkt::low_level::image::heat::heat;
use direkt_instruments::drawing::text::number;
use eframe::egui::{Color32, ColorImage, TextureOptions, Ui, Vec2};
use std::sync::Arc;

/// Shows the pixel that was clicked.
pub fn show(app: &mut App, ui: &mut Ui) {
    let Some(at) = app.inspection.at else {
        ui.weak("Click on the image.");
        return;
    };
    surface(app, ui);
    densities(app, ui);
    for (name, picture) in app.pictures() {
        pixel(ui, picture, at, name);
    }
}

/// Shows how directions are chosen there: expected beside observed.
fn densities(app: &mut App, ui: &mut Ui) {
    let Some(inspected) = app.status.inspected.clone() else {
        return;
    };
    let Some(surface) = &inspected.surface else {
        return;
    };
    let same = |known: &(Arc<Inspected>, _)| Arc::ptr_eq(&known.0, &inspected);
    if !app.inspection.densities.as_ref().is_some_and(same) {
        let load = |values: &[f64], most: f64, name: &str| {
            let colours = values.iter().map(|v| {
                let [r, g, b] = heat(v / most);
                Color32::from_rgb(r, g, b)
            });
            let image = ColorImage::new(CELLS, colours.collect());
            ui.ctx().load_texture(name, image, TextureOptions::NEAREST)
        };
        let pictures = surface.densities.iter().map(|density| {
            let most = density.expected.iter().copied().fold(1e-30, f64::max);
            [&density.expected, &density.observed].map(|values| load(values, most, density.sampler))
        });
        let pictures = pictures.collect();
        app.inspection.densities = Some((Arc::clone(&inspected), pictures));
    }
    let Some((_, pictures)) = &app.inspection.densities else {
        return;
    };
    for (density, pictures) in surface.densities.iter().zip(pictures) {
        let sampler = density.sampler;
        ui.weak(format!(
            "sampling of {sampler}: density, and where samples went"
        ));
        ui.horizontal_wrapped(|ui| {
            for picture in pictures {
                let response = ui.image((picture.id(), Vec2::new(155.0, 77.5)));
                response.on_hover_text(
                    "Azimuth to the right; above the normal, in the middle the horizon, below what lies under the surface. Bright is dense, two and a half \
                     decades in all.",
                );
            }
        });
    }
}

fn surface(app: &App, ui: &mut Ui) {
    let Some(inspected) = &app.status.inspected else {
        return;
    };
    let mut row = |label: &str, text: String| row(ui, label, text);
    match &inspected.surface {
        Some(surface) => {
            row("shape", surface.shape.clone());
            row("material", surface.material.clone());
            let [x, y, z] = surface.position.to_array().map(number);
            row("position", format!("{x}, {y}, {z}"));
            row("depth", number(surface.depth));
        }
        None => row("shape", "none".to_owned()),
    }
}

fn pixel(ui: &mut Ui, picture: &Picture, at: [f64; 2], name: &str) {
    let size = picture.film.size;
    let index = |part: f64, side: u32| ((part * f64::from(side)) as u32).min(side - 1);
    let (x, y) = (index(at[0], size.width), index(at[1], size.height));
    let pixel = &picture.film.pixels[(y * size.width + x) as usize];
    let mut row = |label: &str, text: String| row(ui, format!("{name} {label}").trim(), text);
    let rgb = |v: [f64; 3]| v.map(number).join(", ");
    row("pixel", format!("{x}, {y}"));
    row("radiance", rgb(pixel.mean));
    if let Some(variance) = pixel.variance_of_mean() {
        row("scatter", rgb(variance.map(f64::sqrt)));
    }
    if let Some(half) = pixel.half_difference() {
        row("replicates ±", rgb(half.map(f64::abs)));
    }
    row("samples", pixel.samples.to_string());
}
