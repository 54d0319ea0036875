//! Curves with intervals on logarithmic axes.

use crate::cost::Interval;
use crate::drawing::frame::Area;
use crate::drawing::scale::Scale;
use crate::drawing::svg::{Anchor, Svg, room_for};

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What it is called.
    pub name: String,
    /// Number of its colour.
    pub series: usize,
    /// Number of its dashes and marks.
    pub dash: usize,
    /// Whether it is a thin line with marks that are all the same, crosses.
    pub thin: bool,
    /// x, and y with its interval.
    pub points: Vec<(f64, Interval)>,
}

/// Dashes of the lines, by sampler.
const DASHES: [&str; 4] = ["7 5", "2 4", "", "11 4 2 4"];
/// Marks, by sampler.
const MARKS: [usize; 4] = [1, 3, 0, 2];
/// Mark of thin lines.
const CROSS: usize = 4;
const HEIGHT: f64 = 560.0;
const AREA: Area = Area {
    left: 84.0,
    right: 710.0,
    top: 24.0,
    bottom: 488.0,
};
/// Where names begin, and their size.
const NAMES: f64 = 744.0;
const NAME_SIZE: f64 = 16.0;
/// Least distance of two names' base lines.
const NAME_STEP: f64 = 19.0;

/// Draws `curves`; `guide` is a horizontal line with its name.
pub fn draw(title: &str, axes: [&str; 2], curves: &[Curve], guide: Option<(f64, &str)>) -> Svg {
    let names_room = curves.iter().map(|c| room_for(&c.name, NAME_SIZE));
    let width = NAMES + names_room.fold(0.0, f64::max);
    let mut svg = Svg::new(width, HEIGHT, title);
    let points = || curves.iter().flat_map(|c| &c.points);
    let x = Scale::logarithmic(points().map(|p| p.0), AREA.across());
    let y = Scale::logarithmic(points().map(|p| p.1.value), AREA.upwards());
    AREA.draw(&mut svg, axes, &x, &y);
    if let Some((value, name)) = guide {
        let at = y.at(value);
        if at > AREA.top && at < AREA.bottom {
            let ends = ((AREA.left, at), (AREA.right, at));
            svg.line(ends.0, ends.1, "axis", r#"stroke-dasharray="1 4""#);
            let at = (AREA.left + 8.0, at - 6.0);
            svg.text(at, 13.0, Anchor::Start, "faint", name);
        }
    }
    for curve in curves {
        for (px, interval) in &curve.points {
            whisker(&mut svg, x.at(*px), &y, interval, curve.series);
        }
        let line: Vec<_> = visible(curve).map(|(px, v)| (x.at(px), y.at(v))).collect();
        let width = if curve.thin { 1.4 } else { 2.6 };
        let extra = format!(
            r#"stroke-width="{width}" stroke-linejoin="round" stroke-dasharray="{}""#,
            DASHES[curve.dash % DASHES.len()]
        );
        let mark = if curve.thin {
            CROSS
        } else {
            MARKS[curve.dash % MARKS.len()]
        };
        svg.polyline(&line, &format!("s{}", curve.series), &extra);
        for at in line {
            svg.mark(at, mark, curve.series);
        }
    }
    names(&mut svg, curves, &x, &y);
    svg
}

/// Points that a logarithmic axis can show.
fn visible(curve: &Curve) -> impl Iterator<Item = (f64, f64)> {
    let points = curve.points.iter().map(|(x, i)| (*x, i.value));
    points.filter(|(_, v)| *v > 0.0)
}

fn whisker(svg: &mut Svg, x: f64, y: &Scale, interval: &Interval, series: usize) {
    let (low, high) = (y.at(interval.low), y.at(interval.high));
    if low - high < 2.0 {
        return;
    }
    let class = format!("s{series}");
    svg.line((x, low), (x, high), &class, r#"stroke-width="1.4""#);
    for end in [interval.low, interval.high] {
        // What goes on beyond the plot has no end there.
        if y.holds(end) {
            let ends = ((x - 4.0, y.at(end)), (x + 4.0, y.at(end)));
            svg.line(ends.0, ends.1, &class, r#"stroke-width="1.4""#);
        }
    }
}

/// Names at the curves' ends, moved apart, each with a line to its curve.
fn names(svg: &mut Svg, curves: &[Curve], x: &Scale, y: &Scale) {
    let end = |c: &Curve| visible(c).last().map(|(px, v)| (x.at(px), y.at(v)));
    let mut ends: Vec<_> = curves.iter().filter_map(|c| Some((c, end(c)?))).collect();
    ends.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let wanted: Vec<f64> = ends.iter().map(|(_, at)| at.1).collect();
    for ((curve, from), at) in ends.iter().zip(apart(&wanted)) {
        let class = format!("s{}", curve.series);
        let to = (NAMES - 4.0, at);
        let thin = r#"stroke-width="1" stroke-opacity="0.55""#;
        svg.line((from.0 + 6.0, from.1), to, &class, thin);
        let class = format!("f{}", curve.series);
        let at = (NAMES, at + 5.0);
        svg.text(at, NAME_SIZE, Anchor::Start, &class, &curve.name);
    }
}

/// Positions in rising order that are at least [`NAME_STEP`] apart and inside the plot, near
/// `wanted`.
fn apart(wanted: &[f64]) -> Vec<f64> {
    let mut at = wanted.to_vec();
    let lowest = AREA.bottom + 20.0;
    for i in 1..at.len() {
        at[i] = at[i].max(at[i - 1] + NAME_STEP);
    }
    let mut limit = lowest;
    for y in at.iter_mut().rev() {
        *y = y.min(limit);
        limit = *y - NAME_STEP;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_overlap() {
        let at = apart(&[100.0, 101.0, 102.0, 480.0, 481.0, 482.0]);
        assert!(
            at.windows(2).all(|w| w[1] - w[0] >= NAME_STEP - 1e-9),
            "{at:?}"
        );
        assert!(at.last().is_some_and(|y| *y <= AREA.bottom + 20.0));
    }

    #[test]
    fn errors_below_zero_are_not_drawn() {
        let curve = Curve {
            name: "<n>".to_owned(),
            series: 0,
            dash: 2,
            thin: false,
            points: vec![
                (1.0, Interval::around(0.5, 0.1)),
                (2.0, Interval::around(-0.1, 0.2)),
            ],
        };
        let text = draw("t", ["x", "y"], &[curve], Some((0.5, "g"))).inline();
        assert_eq!(text.matches("<circle").count(), 1);
        assert!(text.contains("&lt;n&gt;") && !text.contains("NaN"));
    }
}
