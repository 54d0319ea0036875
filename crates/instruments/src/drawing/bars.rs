//! Bars with intervals.

use crate::drawing::frame::Area;
use crate::drawing::scale::Scale;
use crate::drawing::svg::{Anchor, Svg, room_for};
use crate::drawing::text::number;
use direkt::low_level::stats::interval::Interval;

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

/// Room for the bars, and beside them for their values.
const BARS: f64 = 510.0;
const RIGHT: f64 = 120.0;
const TOP: f64 = 16.0;
const STEP: f64 = 34.0;
const NAME_SIZE: f64 = 16.0;
const BOTTOM: f64 = 66.0;

/// Draws `bars` from above on a logarithmic axis.
pub fn draw(title: &str, axis: &str, bars: &[Bar]) -> Svg {
    let height = TOP + STEP * bars.len() as f64 + BOTTOM;
    let names_room = bars.iter().map(|b| room_for(&b.name, NAME_SIZE));
    let left = 24.0 + names_room.fold(0.0, f64::max);
    let mut svg = Svg::new(left + BARS + RIGHT, height, title);
    let ends = bars
        .iter()
        .flat_map(|b| [b.value.low, b.value.value, b.value.high]);
    let area = Area {
        left,
        right: left + BARS,
        top: TOP,
        bottom: height - BOTTOM,
    };
    let x = Scale::logarithmic(ends, area.across());
    area.draw_x(&mut svg, &x);
    area.name_x(&mut svg, axis);
    for (i, bar) in bars.iter().enumerate() {
        let middle = TOP + STEP * (i as f64 + 0.5);
        draw_bar(&mut svg, &x, (left, middle), bar);
    }
    svg.line((left, TOP), (left, area.bottom), "axis", "");
    svg
}

fn draw_bar(svg: &mut Svg, x: &Scale, (left, middle): (f64, f64), bar: &Bar) {
    let Interval { value, low, high } = bar.value;
    let end = x.at(value);
    let class = format!("f{}", bar.series);
    let at = (left, middle - 10.0);
    svg.rectangle(
        at,
        (end - left, 20.0),
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
    let name_at = (left - 12.0, middle + 5.5);
    svg.text(name_at, NAME_SIZE, Anchor::End, "ink", &bar.name);
    let value_at = (to.max(end) + 10.0, middle + 5.5);
    let shown = if value.is_finite() {
        number(value)
    } else {
        format!("> {}", number(low))
    };
    svg.text(value_at, 15.0, Anchor::Start, "ink", &shown);
}
