//! Errors against time.

use crate::app::App;
use direkt_instruments::drawing::scale::Scale;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2};

const HEIGHT: f32 = 190.0;
/// Room for numbers to the left and below.
const LEFT: f32 = 44.0;
const BELOW: f32 = 30.0;
/// Colours of the runs that are on screen, A and B, that can be told apart by everyone (Okabe & Ito
/// 2008).
const SHOWN: [Color32; 2] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
];

/// Shows the runs on screen in colour, and those before them in grey.
pub fn show(app: &mut App, ui: &mut Ui) {
    let (response, painter) =
        ui.allocate_painter(Vec2::new(ui.available_width(), HEIGHT), Sense::hover());
    let outer = response.rect;
    let inner = Rect::from_min_max(
        outer.min + Vec2::new(LEFT, 6.0),
        outer.max - Vec2::new(8.0, BELOW),
    );
    let grid = ui.visuals().widgets.noninteractive.bg_stroke.color;
    let text = ui.visuals().weak_text_color();
    let points = || app.runs.iter().flat_map(|run| run.points.iter());
    let ends = |a: f32, b: f32| (f64::from(a), f64::from(b));
    let x = Scale::logarithmic(points().map(|p| p[0]), ends(inner.left(), inner.right()));
    let y = Scale::logarithmic(points().map(|p| p[1]), ends(inner.bottom(), inner.top()));
    // This one has a superscript minus.
    let font = FontId::monospace(10.0);
    for tick in x.ticks() {
        let stroke = Stroke::new(if tick.minor { 0.4 } else { 1.0 }, grid);
        painter.vline(tick.at as f32, inner.y_range(), stroke);
        let at = Pos2::new(tick.at as f32, inner.bottom() + 2.0);
        painter.text(at, Align2::CENTER_TOP, tick.label, font.clone(), text);
    }
    for tick in y.ticks() {
        let stroke = Stroke::new(if tick.minor { 0.4 } else { 1.0 }, grid);
        painter.hline(inner.x_range(), tick.at as f32, stroke);
        let at = Pos2::new(inner.left() - 3.0, tick.at as f32);
        painter.text(at, Align2::RIGHT_CENTER, tick.label, font.clone(), text);
    }
    let at = Pos2::new(inner.right(), outer.bottom());
    painter.text(at, Align2::RIGHT_BOTTOM, "seconds", font.clone(), text);
    let at = Pos2::new(inner.left(), outer.bottom());
    painter.text(at, Align2::LEFT_BOTTOM, "√NMSE", font, text);
    let shown = shown_runs(app);
    for run in app.runs.iter() {
        let view = shown.iter().position(|number| run.is(*number));
        let colour = view.map_or(Color32::from_gray(128), |view| SHOWN[view.min(1)]);
        let stroke = Stroke::new(if view.is_some() { 2.0 } else { 1.0 }, colour);
        let line = run.points.iter();
        let line = line.map(|p| Pos2::new(x.at(p[0]) as f32, y.at(p[1]) as f32));
        painter.add(Shape::line(line.collect(), stroke));
    }
    legend(app, ui, &shown);
}

fn shown_runs(app: &App) -> Vec<u64> {
    let pictures = app.status.pictures.iter().flatten();
    pictures.map(|picture| picture.run).collect()
}

fn legend(app: &mut App, ui: &mut Ui, shown: &[u64]) {
    let mut others = 0;
    for run in app.runs.iter().filter(|run| !run.points.is_empty()) {
        let view = shown.iter().position(|number| run.is(*number));
        let colour = view.map_or(Color32::from_gray(128), |view| SHOWN[view.min(1)]);
        let last = run.points.last().map_or(0.0, |p| 100.0 * p[1]);
        ui.colored_label(colour, format!("{}: {last:.2} %", run.label));
        others += u32::from(view.is_none());
    }
    if others > 0 && ui.small_button("forget the runs before").clicked() {
        app.runs.clear_but(shown);
    }
}
