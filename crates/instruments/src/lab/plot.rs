//! Line plots: both axes linear or logarithmic.

use crate::drawing::frame::Area;
use crate::drawing::scale::Scale;
use crate::drawing::svg::{Anchor, SERIES, Svg};
use serde::Serialize;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A line through the points.
    Line,
    /// A broken line, for theory.
    Dashed,
    /// A line with a dot at every point.
    Dots,
    /// Columns from the axis up to the points, which are their middles.
    Columns,
}

/// Points with a name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// In the legend.
    pub name: String,
    /// (x, y).
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub mark: Mark,
    /// Number of the colour; series that belong together share one.
    pub colour: usize,
}

/// A plot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// Name of the file, without ending.
    pub file: String,
    /// Above the plot.
    pub title: String,
    /// Names of the axes.
    pub axes: [String; 2],
    /// Whether both axes are logarithmic; points that are not positive are left out then.
    pub logarithmic: bool,
    /// What is drawn.
    pub series: Vec<Series>,
}

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 560.0;
const AREA: Area = Area {
    left: 84.0,
    right: 690.0,
    top: 52.0,
    bottom: 488.0,
};
/// Distance of the legend's lines.
const LEGEND_STEP: f64 = 25.0;
/// Columns are at most so wide, in pixels.
const COLUMN: f64 = 40.0;

impl Plot {
    /// The plot, drawn.
    pub fn draw(&self) -> Svg {
        let shown: Vec<Series> = self.series.iter().map(|s| self.shown(s)).collect();
        let points = || shown.iter().flat_map(|s| s.points.iter());
        let (x, y) = if self.logarithmic {
            (
                Scale::logarithmic(points().map(|p| p.0), AREA.across()),
                Scale::logarithmic(points().map(|p| p.1), AREA.upwards()),
            )
        } else {
            let ends = shown.iter().flat_map(Series::ends);
            // Columns and curves stand on zero.
            let heights = points().map(|p| p.1).chain([0.0]);
            (
                Scale::linear(ends, AREA.across()),
                Scale::linear(heights, AREA.upwards()),
            )
        };
        let mut svg = Svg::new(WIDTH, HEIGHT, &self.title);
        let middle = 0.5 * (AREA.left + AREA.right);
        svg.text((middle, 30.0), 19.0, Anchor::Middle, "ink", &self.title);
        AREA.draw(&mut svg, [&self.axes[0], &self.axes[1]], &x, &y);
        for series in &shown {
            series.draw(&mut svg, &x, &y);
        }
        let named = shown.iter().filter(|s| !s.name.is_empty());
        for (i, series) in named.enumerate() {
            series.name_at(&mut svg, AREA.top + 10.0 + LEGEND_STEP * i as f64);
        }
        svg
    }

    /// The points that the axes can show.
    fn shown(&self, series: &Series) -> Series {
        let fits = |v: f64| v.is_finite() && (!self.logarithmic || v > 0.0);
        let points = series.points.iter().copied();
        Series {
            points: points.filter(|p| fits(p.0) && fits(p.1)).collect(),
            ..series.clone()
        }
    }
}

impl Series {
    fn colour(&self) -> usize {
        self.colour % SERIES
    }

    fn dashes(&self) -> &'static str {
        if self.mark == Mark::Dashed { "7 5" } else { "" }
    }

    /// Where it begins and ends in x; columns are as wide as they are apart.
    fn ends(&self) -> Vec<f64> {
        let xs = || self.points.iter().map(|p| p.0);
        let half = match self.mark {
            Mark::Columns => 0.5 * least_gap(xs()).unwrap_or(0.0),
            _ => 0.0,
        };
        xs().flat_map(|x| [x - half, x + half]).collect()
    }

    fn draw(&self, svg: &mut Svg, x: &Scale, y: &Scale) {
        let places = self.points.iter().map(|p| (x.at(p.0), y.at(p.1)));
        let places: Vec<_> = places.collect();
        if self.mark == Mark::Columns {
            self.draw_columns(svg, &places);
            return;
        }
        let extra = format!(
            r#"stroke-width="2.2" stroke-linejoin="round" stroke-dasharray="{}""#,
            self.dashes()
        );
        svg.polyline(&places, &format!("s{}", self.colour()), &extra);
        if self.mark == Mark::Dots {
            for at in places {
                svg.mark(at, 0, self.colour());
            }
        }
    }

    fn draw_columns(&self, svg: &mut Svg, places: &[(f64, f64)]) {
        let gap = least_gap(places.iter().map(|p| p.0));
        let width = 0.9 * gap.unwrap_or(COLUMN).min(COLUMN);
        let class = format!("f{}", self.colour());
        for (x, y) in places {
            let size = (width, AREA.bottom - y);
            let at = (x - 0.5 * width, *y);
            svg.rectangle(at, size, &class, r#"fill-opacity="0.35""#);
        }
    }

    /// A line of the legend.
    fn name_at(&self, svg: &mut Svg, y: f64) {
        let x = AREA.right + 16.0;
        let extra = format!(r#"stroke-width="3" stroke-dasharray="{}""#, self.dashes());
        svg.line(
            (x, y),
            (x + 26.0, y),
            &format!("s{}", self.colour()),
            &extra,
        );
        svg.text((x + 34.0, y + 5.5), 16.0, Anchor::Start, "ink", &self.name);
    }
}

/// The least distance of neighbours among rising `values`; none where there are fewer than two.
fn least_gap(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let pairs = values.clone().zip(values.skip(1));
    pairs.map(|(a, b)| b - a).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(logarithmic: bool, points: &[(f64, f64)]) -> Plot {
        Plot {
            file: "p".to_owned(),
            title: "a < b".to_owned(),
            axes: ["n".to_owned(), "error".to_owned()],
            logarithmic,
            series: vec![Series {
                name: "s & t".to_owned(),
                points: points.to_vec(),
                mark: Mark::Dots,
                colour: 0,
            }],
        }
    }

    #[test]
    fn points_lie_in_the_frame_and_text_is_escaped() {
        let svg = plot(true, &[(1.0, 0.1), (100.0, 0.001), (10.0, 0.0)])
            .draw()
            .inline();
        // The value that has no logarithm is left out.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains("a &lt; b") && svg.contains("s &amp; t"));
        for (attribute, low, high) in [("cx", AREA.left, AREA.right), ("cy", AREA.top, AREA.bottom)]
        {
            let start = format!("{attribute}=\"");
            let values = svg.split(&start).skip(1);
            let values = values.map(|v| v.split('"').next().unwrap().parse::<f64>().unwrap());
            assert!(values.into_iter().all(|v| low < v && v < high), "{svg}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn degenerate_plots_are_drawn() {
        for points in [&[][..], &[(1.0, 1.0)][..], &[(1.0, 0.0), (2.0, 0.0)][..]] {
            for logarithmic in [false, true] {
                let svg = plot(logarithmic, points).draw().inline();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
            }
        }
    }
}
