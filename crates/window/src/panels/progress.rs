//! How far the images are.

use super::PROBLEM;
use super::row::row;
use crate::app::{App, Note};
use crate::mailbox::State;
use crate::picture::Picture;
use direkt_instruments::drawing::text::{grouped, number};
use eframe::egui::Ui;

/// Shows it.
pub fn show(app: &mut App, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let name = app.options.path.file_name().unwrap_or_default();
        ui.strong(name.to_string_lossy());
        let word = if app.paused { "go on" } else { "pause" };
        if ui.small_button(word).on_hover_text("space").clicked() {
            app.paused = !app.paused;
        }
        match &app.status.state {
            State::Compiling => {
                ui.spinner();
                ui.label("compiling");
            }
            State::Rendering => _ = ui.weak("rendering"),
            State::Paused => _ = ui.weak("paused"),
            State::Failed(_) => _ = ui.colored_label(PROBLEM, "stopped"),
        }
    });
    if let State::Failed(message) = &app.status.state {
        ui.colored_label(PROBLEM, message);
    }
    match &app.note {
        Some(Note::Problem(text)) => _ = ui.colored_label(PROBLEM, text),
        Some(Note::Done(text)) => _ = ui.weak(text),
        None => {}
    }
    if let Some(adapter) = &app.status.adapter {
        ui.weak(format!("{} ({})", adapter.name, adapter.driver));
    }
    for (name, picture) in app.pictures() {
        facts(ui, picture, name);
    }
}

fn facts(ui: &mut Ui, picture: &Picture, name: &str) {
    let mut row = |label: &str, text: String| row(ui, format!("{name} {label}").trim(), text);
    let size = picture.film.size;
    row(
        "samples",
        format!(
            "{}, {} × {}, {:.1} s",
            grouped(picture.samples as f64),
            size.width,
            size.height,
            picture.seconds
        ),
    );
    let error = picture.error.map_or_else(
        || "not known yet".to_owned(),
        |e| {
            let [value, low, high] = e.nmse.percent().map(number);
            let doubt = e
                .nmse
                .doubt
                .map(|doubt| format!(", cannot be told: {doubt}"));
            format!("{value} % [{low}, {high}]{}", doubt.unwrap_or_default())
        },
    );
    row("error", error);
    let seconds = picture.seconds.max(1e-9);
    let samples = picture.rays.camera as f64 / seconds / 1e6;
    let rays = picture.rays.total() as f64 / seconds / 1e6;
    row(
        "speed",
        format!("{} M samples/s, {} M rays/s", number(samples), number(rays)),
    );
    row(
        "time",
        format!(
            "{:.1} ms a pass, compiled in {:.2} s",
            picture.pass_seconds * 1e3,
            picture.compile_seconds
        ),
    );
    let ledger = picture.film.ledger;
    if ledger.dropped > 0 {
        row("not finite", format!("{} samples dropped", ledger.dropped));
    }
    if let Some(bias) = &picture.bias {
        row("biased", bias.clone());
    }
}
