//! Small line plots as SVG: both axes linear or logarithmic, colours that also differ in lightness, no scripts.

use serde::Serialize;
use std::fmt::Write;

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
    /// Index of the colour; series that belong together share one.
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

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 52.0;
/// Okabe & Ito 2008: told apart by colour-blind readers as well; then four more.
const COLOURS: [&str; 12] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#666666", "#a08800",
    "#000000", "#7b3294", "#8b4513", "#88a0b0",
];

/// One axis: values to pixels.
struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
    from: f64,
    to: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, logarithmic: bool, (from, to): (f64, f64)) -> Self {
        let scaled = values.map(|v| if logarithmic { v.log10() } else { v });
        let (low, high) = scaled.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        let (low, high) = match (low.is_finite() && high.is_finite(), high > low) {
            (true, true) => (low, high),
            (true, false) => (low - 0.5, low + 0.5),
            _ => (0.0, 1.0),
        };
        let (low, high) = if logarithmic {
            (low.floor(), high.ceil())
        } else {
            (low, high)
        };
        Self {
            low,
            high,
            logarithmic,
            from,
            to,
        }
    }

    fn place(&self, value: f64) -> f64 {
        let v = if self.logarithmic {
            value.log10()
        } else {
            value
        };
        self.from + (v - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Places and labels of the ticks.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.logarithmic {
            let step = ((self.high - self.low) / 8.0).ceil().max(1.0);
            let count = ((self.high - self.low) / step).floor() as i32;
            return (0..=count)
                .map(|i| (self.low + f64::from(i) * step) as i32)
                .map(|power| {
                    let label = format!("10<tspan dy=\"-5\" font-size=\"9\">{power}</tspan>");
                    (self.place(10_f64.powi(power)), label)
                })
                .collect();
        }
        let raw = (self.high - self.low) / 6.0;
        let power = 10_f64.powf(raw.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
        let step = steps.into_iter().find(|&s| s >= raw).unwrap_or(raw);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last)
            .map(|i| i as f64 * step)
            .map(|v| (self.place(v), format!("{v:.decimals$}")))
            .collect()
    }
}

impl Plot {
    /// The SVG, complete in itself, on white ground.
    pub fn svg(&self) -> String {
        let shown: Vec<Series> = self.series.iter().map(|s| self.shown(s)).collect();
        let points = || shown.iter().flat_map(|s| s.points.iter());
        let x = Axis::new(
            points().map(|p| p.0),
            self.logarithmic,
            (LEFT, WIDTH - RIGHT),
        );
        // Columns and curves of linear plots stand on zero.
        let zero = (!self.logarithmic).then_some(0.0);
        let y = Axis::new(
            points().map(|p| p.1).chain(zero),
            self.logarithmic,
            (HEIGHT - BOTTOM, TOP),
        );
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
            escape(&self.title)
        );
        self.frame(&mut out, &x, &y);
        for series in &shown {
            draw(&mut out, series, &x, &y);
        }
        legend(&mut out, &shown);
        out.push_str("</svg>\n");
        out
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

    fn frame(&self, out: &mut String, x: &Axis, y: &Axis) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        for (place, label) in x.ticks() {
            let _ = writeln!(
                out,
                "<path d=\"M{place:.1} {TOP}V{bottom}\" stroke=\"#e4e4e4\"/>\
                 <text x=\"{place:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 18.0
            );
        }
        for (place, label) in y.ticks() {
            let _ = writeln!(
                out,
                "<path d=\"M{LEFT} {place:.1}H{right}\" stroke=\"#e4e4e4\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 8.0,
                place + 4.0
            );
        }
        let middle = 0.5 * (LEFT + right);
        let _ = writeln!(
            out,
            "<path d=\"M{LEFT} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"#333333\"/>\n\
             <text x=\"{middle:.1}\" y=\"24\" text-anchor=\"middle\" font-size=\"14\">{}</text>\n\
             <text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n\
             <text transform=\"translate(18 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&self.title),
            HEIGHT - 12.0,
            escape(&self.axes[0]),
            0.5 * (TOP + bottom),
            escape(&self.axes[1]),
        );
    }
}

fn draw(out: &mut String, series: &Series, x: &Axis, y: &Axis) {
    let colour = COLOURS[series.colour % COLOURS.len()];
    let places: Vec<(f64, f64)> = series
        .points
        .iter()
        .map(|p| (x.place(p.0), y.place(p.1)))
        .collect();
    if series.mark == Mark::Columns {
        let gap = places.windows(2).map(|w| w[1].0 - w[0].0);
        let width = gap.fold(f64::INFINITY, f64::min).min(40.0) * 0.9;
        let bottom = y.from;
        for (px, py) in places {
            let _ = writeln!(
                out,
                "<rect x=\"{:.1}\" y=\"{py:.1}\" width=\"{width:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"0.35\"/>",
                px - 0.5 * width,
                (bottom - py).max(0.0)
            );
        }
        return;
    }
    let mut path = String::new();
    for (i, (px, py)) in places.iter().enumerate() {
        let _ = write!(path, "{}{px:.1} {py:.1}", if i == 0 { "M" } else { "L" });
    }
    let dash = if series.mark == Mark::Dashed {
        " stroke-dasharray=\"5 4\""
    } else {
        ""
    };
    let _ = writeln!(
        out,
        "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"{dash}/>"
    );
    if series.mark == Mark::Dots {
        for (px, py) in places {
            let _ = writeln!(
                out,
                "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"3\" fill=\"{colour}\"/>"
            );
        }
    }
}

fn legend(out: &mut String, series: &[Series]) {
    let x = WIDTH - RIGHT + 14.0;
    for (i, s) in series.iter().filter(|s| !s.name.is_empty()).enumerate() {
        let y = TOP + 10.0 + 18.0 * i as f64;
        let colour = COLOURS[s.colour % COLOURS.len()];
        let dash = if s.mark == Mark::Dashed {
            " stroke-dasharray=\"5 4\""
        } else {
            ""
        };
        let _ = writeln!(
            out,
            "<path d=\"M{x} {y}h20\" stroke=\"{colour}\" stroke-width=\"2.5\"{dash}/>\
             <text x=\"{}\" y=\"{}\">{}</text>",
            x + 26.0,
            y + 4.0,
            escape(&s.name)
        );
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
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
        let svg = plot(true, &[(1.0, 0.1), (100.0, 0.001), (10.0, 0.0)]).svg();
        // The value that has no logarithm is left out.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains("a &lt; b") && svg.contains("s &amp; t"));
        assert!(svg.contains(&format!("cx=\"{LEFT:.1}\" cy=\"{TOP:.1}\"")));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn degenerate_plots_are_drawn() {
        for points in [&[][..], &[(1.0, 1.0)][..], &[(1.0, 0.0), (2.0, 0.0)][..]] {
            for logarithmic in [false, true] {
                let svg = plot(logarithmic, points).svg();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
            }
        }
    }
}
