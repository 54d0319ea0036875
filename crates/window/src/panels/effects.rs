//! What the scene calls for.

use crate::app::App;
use direkt::low_level::effects::Effect;
use eframe::egui::{RichText, Ui};

/// Shows the effects of the view that is edited, with their reasons, and switches that force the
/// others.
pub fn show(app: &mut App, ui: &mut Ui) {
    let index = app.edited_view();
    let forced = app.methods[index].forced.clone();
    let picture = app.status.pictures[index].as_ref();
    let called_for: Vec<_> = picture.map_or_else(Vec::new, |p| {
        let effects = p.effects.iter();
        effects
            .filter(|(e, _)| !forced.contains(e))
            .cloned()
            .collect()
    });
    ui.label("Compiled in, as the scene calls for them:");
    for (effect, reason) in &called_for {
        ui.horizontal_wrapped(|ui| {
            ui.strong(effect.name());
            ui.weak(reason);
        });
    }
    ui.add_space(4.0);
    ui.label("Left out; forced ones change no bit of the image, and cost time:");
    let left_out = Effect::ALL
        .iter()
        .filter(|e| e.can_be_forced() && called_for.iter().all(|(called, _)| called != *e));
    let forced = &mut app.methods[index].forced;
    ui.horizontal_wrapped(|ui| {
        for &effect in left_out {
            let is_forced = forced.contains(&effect);
            let label = RichText::new(effect.name()).small();
            if ui.selectable_label(is_forced, label).clicked() {
                if is_forced {
                    forced.retain(|&e| e != effect);
                } else {
                    forced.push(effect);
                }
            }
        }
    });
}
