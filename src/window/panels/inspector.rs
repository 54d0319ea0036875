//! What is known of one pixel.

use super::row::row;
use crate::drawing::text::number;
use crate::window::app::App;
use crate::window::picture::Picture;
use eframe::egui::Ui;

/// Shows the pixel that was clicked.
pub fn show(app: &mut App, ui: &mut Ui) {
    let Some(at) = app.inspected else {
        ui.weak("Click on the image.");
        return;
    };
    surface(app, ui);
    let pictures = app.news.pictures.iter().zip(["A", "B"]);
    for (picture, name) in pictures {
        if let Some(picture) = picture {
            let name = if app.methods.len() > 1 { name } else { "" };
            pixel(ui, picture, at, name);
        }
    }
}

fn surface(app: &App, ui: &mut Ui) {
    let Some(inspected) = &app.news.inspected else {
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
