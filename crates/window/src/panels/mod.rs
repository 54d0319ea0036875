//! The controls beside the image.

mod effects;
mod estimator;
mod inspector;
mod lights;
mod plot;
mod progress;
mod row;

use super::app::{App, Screen};
use super::request::{Layer, Method, Pacing, VIEW_NAMES};
use direkt::low_level::image::ToneMapper;
use direkt::scene::{LightSampling, Strategy};
use eframe::egui::{self, Color32, ComboBox, RichText, ScrollArea, Ui};
use std::fmt::Display;
use strum::{EnumMessage, VariantArray};

/// Width of the controls, in points.
pub const WIDTH: f32 = 340.0;
const PROBLEM: Color32 = Color32::from_rgb(220, 80, 60);

/// Shows them.
pub fn show(app: &mut App, ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space(4.0);
        progress::show(app, ui);
        section(ui, "Estimator", true, |ui| estimator::show(app, ui));
        section(ui, "Error against time", true, |ui| plot::show(app, ui));
        section(ui, "View", true, |ui| view(app, ui));
        section(ui, "Pixel", false, |ui| inspector::show(app, ui));
        section(ui, "Lights", false, |ui| lights::show(app, ui));
        section(ui, "Effects", false, |ui| effects::show(app, ui));
        section(ui, "Save", false, |ui| save(app, ui));
        section(ui, "Keys", false, keys);
    });
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) {
    ui.separator();
    egui::CollapsingHeader::new(RichText::new(title).strong())
        .default_open(open)
        .show_unindented(ui, content);
}

/// A choice among all values of a setting, each with its description.
fn choice<T>(ui: &mut Ui, label: &str, value: &mut T)
where
    T: VariantArray + EnumMessage + Display + PartialEq + Copy,
{
    ui.horizontal(|ui| {
        row::begin(ui, 105.0, label);
        ComboBox::from_id_salt((label, ui.scope_id()))
            .selected_text(value.to_string())
            .width(200.0)
            .show_ui(ui, |ui| {
                for one in T::VARIANTS {
                    let response = ui.selectable_value(value, *one, one.to_string());
                    response.on_hover_text(one.get_documentation().unwrap_or_default());
                }
            });
    });
}

/// Begins or ends a comparison: the second view begins with the method of the first, but for what
/// makes a difference worth seeing.
pub fn compare(app: &mut App, begin: bool) {
    if !begin {
        app.methods.truncate(1);
        app.comparison.edited = 0;
        if app.display.layer == Layer::Difference {
            app.display.layer = Layer::Radiance;
        }
        return;
    }
    let mut second: Method = app.methods[0].clone();
    let settings = &mut second.settings;
    settings.estimator.strategy = if settings.estimator.strategy.is_mis() {
        match settings.estimator.light_sampling {
            LightSampling::Area => Strategy::LightArea,
            LightSampling::SolidAngle => Strategy::LightSolidAngle,
            LightSampling::ProjectedSolidAngle => Strategy::LightProjectedSolidAngle,
        }
    } else {
        Strategy::MisPower
    };
    app.methods.truncate(1);
    app.methods.push(second);
    app.comparison.screen = Screen::Split;
    app.comparison.edited = 1;
}

/// Goes `step` strategies on in the view that is edited.
pub fn next_strategy(app: &mut App, step: isize) {
    let index = app.edited_view();
    let strategy = &mut app.methods[index].settings.estimator.strategy;
    let all = Strategy::VARIANTS;
    let at = all.iter().position(|s| s == strategy).unwrap_or(0) as isize + step;
    *strategy = all[at.rem_euclid(all.len() as isize) as usize];
}

fn view(app: &mut App, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        for (layer, name) in Layer::ALL {
            let possible = layer != Layer::Difference || app.methods.len() > 1;
            let label = egui::Button::selectable(app.display.layer == layer, name);
            let response = ui.add_enabled(possible, label);
            let response =
                response.on_disabled_hover_text("compare two methods to see their difference");
            if response.clicked() {
                app.display.layer = layer;
            }
        }
    });
    match app.display.layer {
        Layer::Radiance => {
            let exposure = egui::Slider::new(&mut app.display.mapping.exposure, -10.0..=10.0);
            ui.add(exposure.text("exposure, stops").fixed_decimals(1));
            choice::<ToneMapper>(ui, "tone mapper", &mut app.display.mapping.tone);
        }
        Layer::StandardError => {
            ui.label("From dark, 0.3 % of the pixel's value, to light, 100 %.");
        }
        Layer::Difference => {
            ui.label(
                "Blue where A is darker than B, red where it is brighter; full colour at 50 %.",
            );
        }
        Layer::Samples => {
            ui.label(
                "From dark, a sixteenth of the mean number of samples, to light, sixteen times the mean.",
            );
        }
    }
    if app.methods.len() > 1 {
        ui.horizontal_wrapped(|ui| {
            ui.label("at equal");
            ui.selectable_value(&mut app.comparison.pacing, Pacing::EqualTime, "time")
                .on_hover_text("next is the one that has rendered for less time");
            ui.selectable_value(&mut app.comparison.pacing, Pacing::EqualSamples, "samples")
                .on_hover_text("next is the one that has fewer samples");
        });
        ui.horizontal_wrapped(|ui| {
            ui.selectable_value(&mut app.comparison.screen, Screen::Split, "split");
            for (view, name) in VIEW_NAMES.into_iter().enumerate() {
                ui.selectable_value(&mut app.comparison.screen, Screen::One(view), name);
            }
        });
    }
    ui.horizontal_wrapped(|ui| {
        if ui.button("reset camera").on_hover_text("R").clicked() {
            app.go_home();
        }
        if ui
            .button("frame")
            .on_hover_text("F: all, or what was clicked")
            .clicked()
        {
            app.frame_selection();
        }
    });
    lens(app, ui);
}

fn lens(app: &mut App, ui: &mut Ui) {
    if app.scene.file.camera.lens.radius <= 0.0 {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        let mut lens = app.navigation.controller.lens;
        let speed = 0.01 * lens.focus_distance;
        let sharp = egui::DragValue::new(&mut lens.focus_distance);
        ui.add(sharp.speed(speed).range(1e-9..=1e9).prefix("sharp at "));
        let speed = 0.01 * lens.radius.max(1e-3 * lens.focus_distance);
        let radius = egui::DragValue::new(&mut lens.radius);
        ui.add(radius.speed(speed).range(0.0..=1e9).prefix("lens radius "));
        app.navigate(|controller| controller.lens = lens);
    });
    ui.weak("Alt and a click: what is there becomes sharp.");
}

fn save(app: &mut App, ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        ui.add(egui::TextEdit::singleline(&mut app.saving).desired_width(220.0));
        let image = ui
            .button("image")
            .on_hover_text("Ctrl + S: an .exr or a .png");
        if image.clicked() {
            app.save(&app.image_name());
        }
    });
    let scene = app.scene_name();
    ui.horizontal_wrapped(|ui| {
        ui.monospace(scene.display().to_string());
        let button = ui
            .button("scene")
            .on_hover_text("Ctrl + Shift + S: with this camera, size, settings and lights");
        if button.clicked() {
            app.save(&scene);
        }
    });
}

fn keys(ui: &mut Ui) {
    for (keys, what) in [
        ("drag", "turn about the middle"),
        ("shift + drag, middle drag", "move"),
        ("right drag", "look around"),
        ("wheel", "come closer"),
        ("W A S D, Q E", "fly"),
        ("click", "ask about a pixel"),
        ("F", "frame what was clicked, or all"),
        ("R", "camera as in the file"),
        ("C", "compare two methods"),
        ("X", "A or B"),
        ("1 2 3 4", "radiance, standard error, difference, samples"),
        ("[ ]", "the strategy before, the next one"),
        ("Ctrl + S", "save the image"),
        ("Ctrl + Shift + S", "save the scene as it is seen"),
        ("space", "pause"),
        ("H", "hide these controls"),
        ("F11", "full screen"),
    ] {
        ui.horizontal_wrapped(|ui| {
            ui.monospace(keys);
            ui.weak(what);
        });
    }
}
