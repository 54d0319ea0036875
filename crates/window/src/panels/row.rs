//! Facts, a line each.

use eframe::egui::{Align, Label, Layout, RichText, Ui, Vec2};

/// Width of what a line begins with.
const LABEL: f32 = 80.0;

/// What a line begins with, `width` wide.
pub fn begin(ui: &mut Ui, width: f32, label: &str) {
    let size = Vec2::new(width, ui.spacing().interact_size.y);
    let left = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(size, left, |ui| {
        ui.set_min_width(width);
        ui.weak(label);
    });
}

/// A label and what it is about; what does not fit is cut, and shown when pointed at.
pub fn row(ui: &mut Ui, label: &str, text: impl Into<String>) {
    ui.horizontal(|ui| {
        begin(ui, LABEL, label);
        ui.add(Label::new(RichText::new(text).monospace().size(11.5)).truncate());
    });
}
