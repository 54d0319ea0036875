//! The grid behind a plot, and its axes.

use super::scale::{Scale, Tick};
use super::svg::{Anchor, Svg};

/// The part of a drawing in which values are shown, in pixels.
#[derive(Debug, Clone, Copy)]
pub struct Area {
    /// Its left edge.
    pub left: f64,
    /// Its right edge.
    pub right: f64,
    /// Its upper edge.
    pub top: f64,
    /// Its lower edge.
    pub bottom: f64,
}

impl Area {
    /// Pixels of its left and right edge: where a scale along x begins and ends.
    pub fn across(&self) -> (f64, f64) {
        (self.left, self.right)
    }

    /// Pixels of its lower and upper edge: where a scale along y begins and ends.
    pub fn upwards(&self) -> (f64, f64) {
        (self.bottom, self.top)
    }

    /// Draws grid and axes with the axes' names.
    pub fn draw(&self, svg: &mut Svg, names: [&str; 2], x: &Scale, y: &Scale) {
        self.draw_x(svg, x);
        for tick in y.ticks() {
            svg.line(
                (self.left, tick.at),
                (self.right, tick.at),
                tick.class(),
                "",
            );
            let (size, class) = label(&tick);
            let at = (self.left - 10.0, tick.at + 0.36 * size);
            svg.text(at, size, Anchor::End, class, &tick.label);
        }
        svg.line(
            (self.left, self.bottom),
            (self.right, self.bottom),
            "axis",
            "",
        );
        svg.line((self.left, self.top), (self.left, self.bottom), "axis", "");
        self.name_x(svg, names[0]);
        let middle = 0.5 * (self.top + self.bottom);
        svg.vertical_text((24.0, middle), 17.0, names[1]);
    }

    /// Draws the grid of x alone, with its numbers.
    pub fn draw_x(&self, svg: &mut Svg, x: &Scale) {
        for tick in x.ticks() {
            svg.line(
                (tick.at, self.top),
                (tick.at, self.bottom),
                tick.class(),
                "",
            );
            let (size, class) = label(&tick);
            let at = (tick.at, self.bottom + 24.0);
            svg.text(at, size, Anchor::Middle, class, &tick.label);
        }
    }

    /// Writes the name of x below its numbers.
    pub fn name_x(&self, svg: &mut Svg, name: &str) {
        let at = (0.5 * (self.left + self.right), self.bottom + 52.0);
        svg.text(at, 17.0, Anchor::Middle, "ink", name);
    }
}

/// Size and class of a tick's number.
fn label(tick: &Tick) -> (f64, &'static str) {
    if tick.minor {
        (13.0, "faint")
    } else {
        (16.0, "ink")
    }
}
