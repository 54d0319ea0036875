//! Which lights shine.

use crate::app::App;
use eframe::egui::{DragValue, ScrollArea, Ui};

/// Shows the lights with their switches.
pub fn show(app: &mut App, ui: &mut Ui) {
    let before = app.scene.lights.clone();
    if before.0.is_empty() {
        ui.weak("The scene has none.");
        return;
    }
    let height = ui.text_style_height(&eframe::egui::TextStyle::Button) + 6.0;
    ScrollArea::vertical()
        .max_height(200.0)
        .id_salt("lights")
        .show_rows(ui, height, before.0.len(), |ui, rows| {
            for light in &mut app.scene.lights.0[rows] {
                ui.horizontal_wrapped(|ui| {
                    ui.toggle_value(&mut light.solo, "S")
                        .on_hover_text("solo: only such lights shine");
                    ui.toggle_value(&mut light.muted, "M").on_hover_text("mute");
                    let scale = DragValue::new(&mut light.scale);
                    ui.add(scale.speed(0.02).range(0.0..=1e6).prefix("× "));
                    ui.label(&light.name);
                });
            }
        });
    if app.scene.lights != before {
        app.switch_lights();
    }
}
