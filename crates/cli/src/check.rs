//! `direkt render --check`: what the scene's `[expect]` table says against what was rendered.

use direkt::error::Error;
use direkt::low_level::console::print;
use direkt::low_level::render::Film;
use direkt::low_level::render::check::{Check, Failure, require_samples};
use direkt::scene::Scene;
use std::fmt::Write;

/// Failing values that are printed; `--json` has all of them.
const PRINTED: usize = 20;

/// Whether to check.
#[derive(Debug, clap::Args)]
pub struct CheckArgument {
    /// Compare with the exact values of the scene's [expect] table: exit 0 when all agree, 1 when
    /// not
    #[arg(long, conflicts_with = "size")]
    pub check: bool,
}

impl CheckArgument {
    /// Refuses what could not be checked in the end, before anything is rendered.
    pub fn before(&self, scene: &Scene) -> Result<(), Error> {
        if !self.check {
            return Ok(());
        }
        if scene.expect.is_none() {
            return Err(Error::Usage(format!(
                "--check: {} has no table [expect] that says what the image must be",
                scene.source.display()
            )));
        }
        require_samples(scene.render.stop.spp)
    }

    /// The comparison, when it was asked for.
    pub fn compare(&self, scene: &Scene, film: &Film) -> Result<Option<Check>, Error> {
        let expect = scene.expect.as_ref().filter(|_| self.check);
        expect.map(|expect| Check::new(film, expect)).transpose()
    }
}

/// Prints the verdict, and each failing value with what was expected and the bound.
pub fn print_verdict(check: &Check) {
    let mut text = String::new();
    for failure in check.failures.iter().take(PRINTED) {
        text += &failure_line(failure);
    }
    if let Some(more) = check.failures.len().checked_sub(PRINTED + 1) {
        let _ = writeln!(text, "and {} more", more + 1);
    }
    if check.dropped > 0 {
        let _ = writeln!(text, "{} samples were not finite", check.dropped);
    }
    // Writing into a String cannot fail.
    let _ = writeln!(
        text,
        "check {}: {} values, worst {:.2} standard errors, bound {:.2}; expected values: {}",
        if check.passed { "passed" } else { "FAILED" },
        check.values,
        check.worst_sigma,
        check.bound_sigma,
        check.source,
    );
    print(&text);
}

fn failure_line(failure: &Failure) -> String {
    let place = match failure.pixel {
        Some([x, y]) => format!("pixel ({x}, {y})"),
        None => "image mean".to_owned(),
    };
    format!(
        "{place}, {}: found {}, expected {}, off by {:.3e}, bound {:.3e}\n",
        ["red", "green", "blue"][failure.channel],
        failure.found,
        failure.expected,
        (failure.found - failure.expected).abs(),
        failure.bound,
    )
}
