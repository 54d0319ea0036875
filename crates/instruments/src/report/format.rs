//! Times, intervals and slopes as people read them.

use crate::cost::Interval;
use crate::cost::effects::Agreement;
use crate::cost::fit::Slope;
pub use crate::drawing::text::{escape, grouped, number, short};

/// Seconds in the unit that suits them.
pub fn seconds(s: f64) -> String {
    let with = |x: f64, unit: &str| format!("{} {unit}", number(x));
    match s {
        s if !s.is_finite() => "∞".to_owned(),
        s if s < 1e-6 => with(s * 1e9, "ns"),
        s if s < 1e-3 => with(s * 1e6, "µs"),
        s if s < 1.0 => with(s * 1e3, "ms"),
        s if s < 180.0 => with(s, "s"),
        s if s < 10_800.0 => with(s / 60.0, "min"),
        s if s < 172_800.0 => with(s / 3600.0, "h"),
        s => with(s / 86_400.0, "days"),
    }
}

/// `[low, high]`.
pub fn range(interval: &Interval, show: impl Fn(f64) -> String) -> String {
    format!("[{}, {}]", show(interval.low), show(interval.high))
}

/// A slope with its standard error.
pub fn slope(slope: Option<Slope>) -> String {
    slope.map_or_else(
        || "—".to_owned(),
        |s| {
            let sign = if s.value < 0.0 { "−" } else { "" };
            format!("{sign}{:.2} ± {:.2}", s.value.abs(), s.standard_error)
        },
    )
}

/// Whether images are the same.
pub fn agreement(found: &Agreement) -> String {
    let all = grouped(found.pixels as f64);
    let images = if found.images == 1 { "image" } else { "images" };
    let (differ, count) = (grouped(found.pixels_differ as f64), found.images);
    if found.is_exact() {
        format!("the same image bit for bit ({all} pixels of {count} {images} compared)")
    } else {
        format!("another image: {differ} of {all} pixels of {count} {images} differ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_units() {
        assert_eq!(seconds(2.5e-8), "25.0 ns");
        assert_eq!(seconds(0.25), "250 ms");
        assert_eq!(seconds(600.0), "10.0 min");
    }

    #[test]
    fn images_that_differ_are_no_same_images() {
        let mut found = Agreement {
            images: 1,
            pixels: 384,
            pixels_differ: 0,
        };
        let same = "the same image bit for bit (384 pixels of 1 image compared)";
        assert_eq!(agreement(&found), same);
        found.pixels_differ = 2;
        assert_eq!(
            agreement(&found),
            "another image: 2 of 384 pixels of 1 image differ"
        );
    }
}
