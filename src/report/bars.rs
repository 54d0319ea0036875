//! Bars with intervals.

use super::format::number;
use super::scale::LogScale;
use super::svg::{Anchor, Svg};
use crate::cost::Interval;

/// A bar.
#[derive(Debug, Clone)]
pub struct Bar {
    /// What stands before it.
    pub name: String,
    /// Number of its colour.
    pub series: usize,
    /// Its length.
    pub value: Interval,
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 330.0;
const RIGHT: f64 = 120.0;
const TOP: f64 = 16.0;
const STEP: f64 = 34.0;
const BOTTOM: f64 = 62.0;

/// Draws `bars` from above on a logarithmic axis.
pub fn draw(title: &str, axis: &str, bars: &[Bar]) -> Svg {
    let height = TOP + STEP * bars.len() as f64 + BOTTOM;
    let mut svg = Svg::new(WIDTH, height, title);
    let ends = bars
        .iter()
        .flat_map(|b| [b.value.low, b.value.value, b.value.high]);
    let x = LogScale::over(ends, LEFT, WIDTH - RIGHT);
    let bottom = height - BOTTOM;
    for v in x.minor() {
        svg.line((x.at(v), TOP), (x.at(v), bottom), "minor", "");
        if x.is_short() {
            let at = (x.at(v), bottom + 20.0);
            svg.text(at, 13.0, Anchor::Middle, "faint", &number(v));
        }
    }
    for d in x.decades() {
        let at = x.at(10_f64.powi(d));
        svg.line((at, TOP), (at, bottom), "grid", "");
        svg.power((at, bottom + 24.0), 16.0, Anchor::Middle, d);
    }
    for (i, bar) in bars.iter().enumerate() {
        let middle = TOP + STEP * (i as f64 + 0.5);
        draw_bar(&mut svg, &x, middle, bar);
    }
    svg.line((LEFT, TOP), (LEFT, bottom), "axis", "");
    let at = (0.5 * (LEFT + WIDTH - RIGHT), height - 14.0);
    svg.text(at, 17.0, Anchor::Middle, "ink", axis);
    svg
}

fn draw_bar(svg: &mut Svg, x: &LogScale, middle: f64, bar: &Bar) {
    let Interval { value, low, high } = bar.value;
    let end = x.at(value);
    let class = format!("f{}", bar.series);
    let at = (LEFT, middle - 10.0);
    svg.rectangle(
        at,
        (end - LEFT, 20.0),
        &class,
        r#"fill-opacity="0.55" rx="2""#,
    );
    let (from, to) = (x.at(low), x.at(high));
    let whisker = r#"stroke-width="2.2""#;
    let class = format!("s{}", bar.series);
    svg.line((from, middle), (to, middle), &class, whisker);
    for at in [from, to] {
        svg.line((at, middle - 7.0), (at, middle + 7.0), &class, whisker);
    }
    let name_at = (LEFT - 12.0, middle + 5.5);
    svg.text(name_at, 16.0, Anchor::End, "ink", &bar.name);
    let value_at = (to.max(end) + 10.0, middle + 5.5);
    let shown = if value.is_finite() {
        number(value)
    } else {
        format!("> {}", number(low))
    };
    svg.text(value_at, 15.0, Anchor::Start, "ink", &shown);
}
