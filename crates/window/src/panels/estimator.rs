//! How light is found.

use super::{choice, compare};
use crate::app::App;
use crate::request::VIEW_NAMES;
use direkt::scene::settings::MAX_SPECULAR_DEPTH;
use direkt::scene::shadow_rays::MAX_SHADOW_RAYS;
use direkt::scene::{LightSampling, LightSelection, Sampler, ShadowPattern, ShadowRays, Strategy};
use eframe::egui::{DragValue, Ui};

/// Shows the controls of the view that is edited.
pub fn show(app: &mut App, ui: &mut Ui) {
    let mut compared = app.methods.len() > 1;
    ui.horizontal_wrapped(|ui| {
        let toggled = ui.checkbox(&mut compared, "compare two methods");
        if toggled.on_hover_text("C").changed() {
            compare(app, compared);
        }
        if app.methods.len() > 1 {
            for (view, name) in VIEW_NAMES.into_iter().enumerate() {
                ui.selectable_value(&mut app.comparison.edited, view, name);
            }
        }
    });
    let index = app.edited_view();
    let settings = &mut app.methods[index].settings;
    choice::<Strategy>(ui, "strategy", &mut settings.estimator.strategy);
    choice::<LightSelection>(
        ui,
        "light selection",
        &mut settings.estimator.light_selection,
    );
    if settings.estimator.strategy.is_mis() {
        choice::<LightSampling>(ui, "light sampling", &mut settings.estimator.light_sampling);
        ui.checkbox(
            &mut settings.estimator.mis_compensation,
            "MIS compensation of the environment",
        );
    }
    choice::<Sampler>(ui, "sampler", &mut settings.estimator.sampler);
    ui.checkbox(
        &mut settings.estimator.adaptive,
        "adaptive: more samples where the error is",
    );
    ui.horizontal_wrapped(|ui| {
        shadow_rays(ui, &mut settings.estimator.shadow_rays);
        let depth = DragValue::new(&mut settings.estimator.max_specular_depth);
        ui.add(
            depth
                .range(0..=MAX_SPECULAR_DEPTH)
                .prefix("specular depth "),
        );
    });
    if settings.estimator.shadow_rays.most() > 1
        || settings.estimator.shadow_pattern != ShadowPattern::default()
    {
        choice::<ShadowPattern>(ui, "shadow pattern", &mut settings.estimator.shadow_pattern);
    }
    ui.checkbox(
        &mut settings.estimator.energy_compensation,
        "energy compensation of rough metals",
    );
    ui.horizontal_wrapped(|ui| {
        ui.add(DragValue::new(&mut settings.seed).prefix("seed "));
    });
}

/// A number, or `auto` at its left end.
fn shadow_rays(ui: &mut Ui, rays: &mut ShadowRays) {
    let mut number = match *rays {
        ShadowRays::Auto => 0,
        ShadowRays::Number(number) => number,
    };
    let value = DragValue::new(&mut number)
        .range(0..=MAX_SHADOW_RAYS)
        .custom_formatter(|number, _| match number {
            0.0 => ShadowRays::Auto.to_string(),
            number => number.to_string(),
        })
        .custom_parser(|text| match text.trim().parse().ok()? {
            ShadowRays::Auto => Some(0.0),
            ShadowRays::Number(number) => Some(f64::from(number)),
        })
        .suffix(" shadow rays");
    ui.add(value);
    *rays = match number {
        0 => ShadowRays::Auto,
        number => ShadowRays::Number(number),
    };
}
