//! Curves with intervals on logarithmic axes.

use super::format::number;
use super::scale::LogScale;
use super::svg::{Anchor, Svg};
use crate::cost::Interval;

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What it is called.
    pub name: String,
    /// Number of its colour.
    pub series: usize,
    /// Number of its dashes and marks.
    pub dash: usize,
    /// x, and y with its interval.
    pub points: Vec<(f64, Interval)>,
}

/// Dashes of the lines, by sampler.
const DASHES: [&str; 4] = ["7 5", "2 4", "", "11 4 2 4"];
/// Marks, by sampler.
const MARKS: [usize; 4] = [1, 3, 0, 2];
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 250.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 72.0;
/// Least distance of two names' base lines.
const NAME_STEP: f64 = 19.0;

/// Draws `curves`; `guide` is a horizontal line with its name.
pub fn draw(title: &str, axes: [&str; 2], curves: &[Curve], guide: Option<(f64, &str)>) -> Svg {
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    let points = || curves.iter().flat_map(|c| &c.points);
    let x = LogScale::over(points().map(|p| p.0), LEFT, WIDTH - RIGHT);
    let values = points().map(|p| p.1.value);
    let y = LogScale::over(values, HEIGHT - BOTTOM, TOP);
    grid(&mut svg, axes, &x, &y);
    if let Some((value, name)) = guide {
        let at = y.at(value);
        if at > TOP && at < HEIGHT - BOTTOM {
            let ends = ((LEFT, at), (WIDTH - RIGHT, at));
            svg.line(ends.0, ends.1, "axis", r#"stroke-dasharray="1 4""#);
            svg.text((LEFT + 8.0, at - 6.0), 13.0, Anchor::Start, "faint", name);
        }
    }
    for curve in curves {
        for (px, interval) in &curve.points {
            whisker(&mut svg, x.at(*px), &y, interval, curve.series);
        }
        let line: Vec<_> = visible(curve).map(|(px, v)| (x.at(px), y.at(v))).collect();
        let extra = format!(
            r#"stroke-width="2.6" stroke-linejoin="round" stroke-dasharray="{}""#,
            DASHES[curve.dash % DASHES.len()]
        );
        svg.polyline(&line, &format!("s{}", curve.series), &extra);
        for at in line {
            svg.mark(at, MARKS[curve.dash % MARKS.len()], curve.series);
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

fn whisker(svg: &mut Svg, x: f64, y: &LogScale, interval: &Interval, series: usize) {
    let (low, high) = (y.at(interval.low), y.at(interval.high));
    if low - high < 2.0 {
        return;
    }
    let class = format!("s{series}");
    svg.line((x, low), (x, high), &class, r#"stroke-width="1.4""#);
    for end in [low, high] {
        svg.line(
            (x - 4.0, end),
            (x + 4.0, end),
            &class,
            r#"stroke-width="1.4""#,
        );
    }
}

fn grid(svg: &mut Svg, axes: [&str; 2], x: &LogScale, y: &LogScale) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    for v in x.minor() {
        let at = x.at(v);
        svg.line((at, TOP), (at, bottom), "minor", "");
        if x.is_short() {
            svg.text(
                (at, bottom + 22.0),
                13.0,
                Anchor::Middle,
                "faint",
                &number(v),
            );
        }
    }
    for v in y.minor() {
        let at = y.at(v);
        svg.line((LEFT, at), (right, at), "minor", "");
        if y.is_short() {
            svg.text(
                (LEFT - 10.0, at + 4.0),
                13.0,
                Anchor::End,
                "faint",
                &number(v),
            );
        }
    }
    for d in x.decades() {
        let at = x.at(10_f64.powi(d));
        svg.line((at, TOP), (at, bottom), "grid", "");
        svg.power((at, bottom + 24.0), 16.0, Anchor::Middle, d);
    }
    for d in y.decades() {
        let at = y.at(10_f64.powi(d));
        svg.line((LEFT, at), (right, at), "grid", "");
        svg.power((LEFT - 10.0, at + 6.0), 16.0, Anchor::End, d);
    }
    svg.line((LEFT, bottom), (right, bottom), "axis", "");
    svg.line((LEFT, TOP), (LEFT, bottom), "axis", "");
    let middle = (0.5 * (LEFT + right), HEIGHT - 18.0);
    svg.text(middle, 17.0, Anchor::Middle, "ink", axes[0]);
    svg.vertical_text((24.0, 0.5 * (TOP + bottom)), 17.0, axes[1]);
}

/// Names at the curves' ends, moved apart, each with a line to its curve.
fn names(svg: &mut Svg, curves: &[Curve], x: &LogScale, y: &LogScale) {
    let end = |c: &Curve| visible(c).last().map(|(px, v)| (x.at(px), y.at(v)));
    let mut ends: Vec<_> = curves.iter().filter_map(|c| Some((c, end(c)?))).collect();
    ends.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let wanted: Vec<f64> = ends.iter().map(|(_, at)| at.1).collect();
    let text_x = WIDTH - RIGHT + 34.0;
    for ((curve, from), at) in ends.iter().zip(apart(&wanted)) {
        let class = format!("s{}", curve.series);
        let to = (text_x - 4.0, at);
        let thin = r#"stroke-width="1" stroke-opacity="0.55""#;
        svg.line((from.0 + 6.0, from.1), to, &class, thin);
        let class = format!("f{}", curve.series);
        svg.text((text_x, at + 5.0), 16.0, Anchor::Start, &class, &curve.name);
    }
}

/// Positions in rising order that are at least [`NAME_STEP`] apart and inside the plot, near `wanted`.
fn apart(wanted: &[f64]) -> Vec<f64> {
    let mut at = wanted.to_vec();
    let lowest = HEIGHT - BOTTOM + 20.0;
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
        assert!(at.last().is_some_and(|y| *y <= HEIGHT - BOTTOM + 20.0));
    }

    #[test]
    fn errors_below_zero_are_not_drawn() {
        let curve = Curve {
            name: "<n>".to_owned(),
            series: 0,
            dash: 2,
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
