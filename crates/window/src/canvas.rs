//! The image on screen, and how one moves through it.

use super::app::{App, Screen};
use super::request::{Layer, VIEW_NAMES};
use eframe::egui::{self, Color32, Key, Modifiers, PointerButton, Pos2, Rect, Sense, Ui, Vec2};

/// Radians that the camera turns by when the pointer crosses the image.
const TURN: f32 = std::f32::consts::PI;
/// Part of its distance that a camera flies in a second.
const FLIGHT: f64 = 0.5;
/// Factor on the distance for one point of scrolling.
const SCROLL: f64 = 0.0015;
/// Points around the split within which it is taken hold of.
const GRIP: f32 = 6.0;

/// Shows the image and takes what is done to it.
pub fn show(app: &mut App, ui: &mut Ui) {
    let rect = ui.max_rect();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    let scale = ui.ctx().pixels_per_point();
    app.resize([rect.width() * scale, rect.height() * scale]);
    paint(app, ui, rect);
    let splits = app.methods.len() > 1 && app.comparison.screen == Screen::Split;
    if splits && drag_split(app, ui, rect) {
        return;
    }
    drag(app, ui, &response, rect);
    fly(app, ui.ctx());
    if let Some(at) = response
        .interact_pointer_pos()
        .filter(|_| response.clicked())
    {
        let part = (at - rect.min) / rect.size();
        app.inspection.at = Some([part.x.into(), part.y.into()]);
        let focusing = ui.input(|input| input.modifiers.alt);
        app.inspection.focusing = focusing && app.navigation.controller.lens.radius > 0.0;
    }
}

fn paint(app: &App, ui: &Ui, rect: Rect) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, Color32::from_gray(24));
    let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    let image = |index: usize, clip: Rect| {
        if let Some(texture) = &app.textures[index] {
            let clipped = painter.with_clip_rect(clip);
            clipped.image(texture.id(), rect, uv, Color32::WHITE);
        }
    };
    let difference = app.display.layer == Layer::Difference;
    match app.comparison.screen {
        Screen::Split if app.methods.len() > 1 && !difference => {
            let x = split_at(app, rect);
            image(0, Rect::from_min_max(rect.min, Pos2::new(x, rect.max.y)));
            image(1, Rect::from_min_max(Pos2::new(x, rect.min.y), rect.max));
            let line = (2.0, Color32::WHITE);
            painter.vline(x, rect.y_range(), line);
            caption(
                app,
                &painter,
                0,
                rect.left_top() + Vec2::splat(8.0),
                egui::Align2::LEFT_TOP,
            );
            let right = rect.right_top() + Vec2::new(-8.0, 8.0);
            caption(app, &painter, 1, right, egui::Align2::RIGHT_TOP);
        }
        Screen::One(index) if index < app.methods.len() => {
            image(index, rect);
            if app.methods.len() > 1 {
                let at = rect.left_top() + Vec2::splat(8.0);
                caption(app, &painter, index, at, egui::Align2::LEFT_TOP);
            }
        }
        _ => image(0, rect),
    }
    if let Some([x, y]) = app.inspection.at {
        let at = rect.min + rect.size() * Vec2::new(x as f32, y as f32);
        painter.circle_stroke(at, 5.0, (2.5, Color32::BLACK));
        painter.circle_stroke(at, 5.0, (1.0, Color32::WHITE));
    }
}

/// Names the view `index`, with its error.
fn caption(app: &App, painter: &egui::Painter, index: usize, at: Pos2, align: egui::Align2) {
    let mut text = format!(
        "{}: {}",
        VIEW_NAMES[index], app.methods[index].settings.estimator.strategy
    );
    if let Some(picture) = &app.status.pictures[index] {
        text += &format!("\n{} samples, {:.1} s", picture.samples, picture.seconds);
        if let Some(error) = picture.error {
            text += &format!("\nerror {:.2} %", error.nmse.percent()[0]);
        }
    }
    let font = egui::FontId::proportional(14.0);
    let galley = painter.layout_no_wrap(text, font, Color32::WHITE);
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min, galley, Color32::WHITE);
}

fn split_at(app: &App, rect: Rect) -> f32 {
    rect.min.x + app.comparison.split * rect.width()
}

/// Moves the split; whether it has hold of it.
fn drag_split(app: &mut App, ui: &mut Ui, rect: Rect) -> bool {
    let x = split_at(app, rect);
    let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
    let response = ui.interact(grip, ui.scope_id().with("split"), Sense::drag());
    let response = response.on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(at) = response
        .interact_pointer_pos()
        .filter(|_| response.dragged())
    {
        app.comparison.split = ((at.x - rect.min.x) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    response.dragged()
}

/// Turns, moves and approaches.
fn drag(app: &mut App, ui: &Ui, response: &egui::Response, rect: Rect) {
    let shift = ui.input(|input| input.modifiers.shift);
    let by = response.drag_delta() / rect.height().max(1.0);
    let (x, y) = (f64::from(by.x), f64::from(by.y));
    let (right, up) = (f64::from(TURN * by.x), f64::from(TURN * by.y));
    if by != Vec2::ZERO {
        if response.dragged_by(PointerButton::Middle)
            || (shift && response.dragged_by(PointerButton::Primary))
        {
            app.navigate(|controller| controller.pan(-x, y));
        } else if response.dragged_by(PointerButton::Primary) {
            app.navigate(|controller| controller.orbit(-right, up));
        } else if response.dragged_by(PointerButton::Secondary) {
            app.navigate(|controller| controller.look(right, -up));
        }
    }
    if response.contains_pointer() {
        let scrolled = ui.input(|input| f64::from(input.smooth_scroll_delta().y));
        if scrolled.abs() > 0.0 {
            app.navigate(|controller| controller.dolly((-SCROLL * scrolled).exp()));
        }
    }
}

/// Flies while keys are held.
fn fly(app: &mut App, context: &egui::Context) {
    if context.egui_wants_keyboard_input() {
        return;
    }
    let (along, seconds) = context.input(|input| {
        let held = |key| f64::from(u8::from(input.key_down(key)));
        let plain = !input.modifiers.command && !input.modifiers.alt;
        let along = [
            held(Key::D) - held(Key::A),
            held(Key::E) - held(Key::Q),
            held(Key::W) - held(Key::S),
        ];
        let along = if plain { along } else { [0.0; 3] };
        (along, f64::from(input.stable_dt.min(0.1)))
    });
    if along.iter().any(|x| x.abs() > 0.0) {
        app.navigate(|controller| controller.fly(along.map(|x| FLIGHT * seconds * x)));
        context.request_repaint();
    }
}

/// What keys do beside flying.
pub fn shortcuts(app: &mut App, context: &egui::Context) {
    let save = |modifiers| context.input_mut(|input| input.consume_key(modifiers, Key::S));
    // The one with more modifiers first: it would be taken for the other.
    if save(Modifiers::COMMAND | Modifiers::SHIFT) {
        app.save(&app.scene_name());
    } else if save(Modifiers::COMMAND) {
        app.save(&app.image_name());
    }
    if context.egui_wants_keyboard_input() {
        return;
    }
    let pressed = |key| context.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if pressed(Key::F) {
        app.frame_selection();
    }
    if pressed(Key::R) || pressed(Key::Home) {
        app.go_home();
    }
    if pressed(Key::Space) {
        app.paused = !app.paused;
    }
    if pressed(Key::H) {
        app.display.panel = !app.display.panel;
    }
    if pressed(Key::F11) {
        let full = context.input(|input| input.viewport().fullscreen.unwrap_or(false));
        context.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!full));
    }
    if pressed(Key::Escape) {
        app.inspection.at = None;
    }
    if pressed(Key::X) && app.methods.len() > 1 {
        app.comparison.screen = match app.comparison.screen {
            Screen::One(0) => Screen::One(1),
            _ => Screen::One(0),
        };
    }
    for (key, step) in [(Key::OpenBracket, -1), (Key::CloseBracket, 1)] {
        if pressed(key) {
            super::panels::next_strategy(app, step);
        }
    }
    if pressed(Key::C) {
        super::panels::compare(app, app.methods.len() < 2);
    }
    for (key, (layer, _)) in [Key::Num1, Key::Num2, Key::Num3, Key::Num4]
        .into_iter()
        .zip(Layer::ALL)
    {
        if pressed(key) {
            app.display.layer = layer;
        }
    }
}
