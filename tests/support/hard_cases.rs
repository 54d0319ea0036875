//! The hard cases: what breaks renderers that compute in f32, and that direkt survives it.
//!
//! A test hands what it measured to [`survive`]: the figure of the textbook's way, which has to be
//! beyond the bound, or else the test would prove nothing, and the figure of direkt's. With the
//! environment variable `DIREKT_HARD_CASES` set, a run of the whole suite writes them to
//! `docs/hard-cases/` and from these `docs/hard-cases.md`.

pub mod document;

use direkt::low_level::gpu::Context;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, Once};

/// One thing that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HardCase {
    /// The entry of [`ENTRIES`].
    pub entry: String,
    /// What is done, with its magnitude.
    pub case: String,
    /// What is measured.
    pub figure: String,
    /// What it may be at most.
    pub bound: f64,
    /// The textbook's way; none where it gives no finite number.
    pub naive: Option<f64>,
    /// Which way that is.
    pub textbook: String,
    /// direkt's way.
    pub ours: f64,
    /// Whether the textbook's way does on some drivers.
    #[serde(default)]
    pub by_driver: bool,
}

/// Identifiers and titles of the hard cases.
pub const ENTRIES: [(&str, &str); 46] = [
    (
        "G1",
        "Rays between triangles with an edge or a vertex in common",
    ),
    ("G2", "Slivers, degenerate triangles, grazing rays"),
    ("G3", "Scenes far from the origin"),
    ("G4", "Hit points and self-intersection"),
    ("G5", "Ends of shadow rays"),
    ("G6", "Boxes that a ray touches"),
    ("G7", "Depth of the hierarchy"),
    ("G8", "Small and distant spheres"),
    ("G9", "Lights that touch surfaces"),
    (
        "G10",
        "Lights edge-on, from behind, in the plane, below the horizon",
    ),
    ("S1", "Random numbers of 1"),
    ("S2", "Choices over many orders of magnitude"),
    ("S3", "Solid angles of triangles"),
    ("S4", "Solid angles of rectangles"),
    ("S5", "Far spheres"),
    ("S6", "Inside a sphere that shines"),
    ("S7", "Points, spots, directions, disks"),
    ("S8", "Poles of environment maps"),
    ("B1", "Almost perfect mirrors"),
    ("B2", "Energy"),
    ("B3", "Grazing angles"),
    ("B4", "Half vectors that vanish"),
    ("B5", "Reciprocity"),
    ("B6", "Light from below the surface"),
    ("M1", "Weights of densities over the whole range"),
    ("M2", "One density, told in two places"),
    ("A1", "Ten million samples"),
    ("A2", "Compensated sums"),
    ("A3", "Small variance of a large mean"),
    ("A4", "Samples that are not finite"),
    ("A5", "Images brighter than half floats"),
    ("A6", "Counters and seeds"),
    ("P1", "NaN and infinity"),
    ("P2", "Subnormal numbers"),
    ("P3", "Elementary functions"),
    ("P4", "Images larger than a binding"),
    ("P5", "Images that fit no workgroup"),
    ("P6", "Watchdogs and lost devices"),
    ("I1", "Vertices that are not finite, triangles without area"),
    ("I2", "Singular transforms"),
    ("I3", "Degenerate cameras"),
    ("I4", "Empty scenes"),
    ("L1", "Loops that the driver cuts"),
    ("L2", "A light a hundredth below the ceiling"),
    ("L3", "Small bindings"),
    ("L4", "Subgroups"),
];

/// What a test measured, for [`survive`].
#[derive(Debug, Clone, Copy)]
pub struct Measured<'a> {
    /// The entry of [`ENTRIES`].
    pub entry: &'a str,
    /// What is done, with its magnitude.
    pub case: &'a str,
    /// What is measured.
    pub figure: &'a str,
    /// What it may be at most.
    pub bound: f64,
    /// Which way the textbook's is.
    pub textbook: &'a str,
    /// What comes of it.
    pub naive: f64,
    /// What comes of direkt's.
    pub ours: f64,
}

static MEASURED: Mutex<Vec<(String, HardCase)>> = Mutex::new(Vec::new());

/// Fails unless direkt's figure is within the bound and the textbook's is beyond it, or not finite.
/// Both are entered.
#[track_caller]
pub fn survive(context: &Context, measured: Measured<'_>) {
    let (naive, bound) = (measured.naive, measured.bound);
    assert!(
        !naive.is_finite() || naive > bound,
        "{}, {}: {} survives too, with {} {naive:e} of {bound:e}, on {}: nothing is shown",
        measured.entry,
        measured.case,
        measured.textbook,
        measured.figure,
        context.adapter.driver
    );
    check_and_enter(context, measured, false);
}

/// The same where it is for the driver to decide whether the textbook's way does: on one of the
/// drivers of the page it must not.
#[track_caller]
pub fn survive_by_driver(context: &Context, measured: Measured<'_>) {
    check_and_enter(context, measured, true);
}

#[track_caller]
fn check_and_enter(context: &Context, measured: Measured<'_>, by_driver: bool) {
    let Measured {
        entry,
        case,
        figure,
        bound,
        textbook,
        naive,
        ours,
    } = measured;
    assert!(
        ENTRIES.iter().any(|(id, _)| *id == entry),
        "there is no hard case {entry}"
    );
    let driver = &context.adapter.driver;
    assert!(
        ours <= bound,
        "{entry}, {case}: {figure} {ours:e}, more than {bound:e}, on {driver}"
    );
    enter(
        driver,
        HardCase {
            entry: entry.to_owned(),
            case: case.to_owned(),
            figure: figure.to_owned(),
            bound,
            naive: naive.is_finite().then_some(naive),
            textbook: textbook.to_owned(),
            ours,
            by_driver,
        },
    );
}

fn enter(driver: &str, case: HardCase) {
    static AT_EXIT: Once = Once::new();
    AT_EXIT.call_once(|| super::at_exit(write));
    MEASURED
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
        .push((driver.to_owned(), case));
}

extern "C" fn write() {
    if std::env::var_os("DIREKT_HARD_CASES").is_none() {
        return;
    }
    let measured = MEASURED
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let told = match document::write(&measured) {
        Ok(()) => "hard cases: written to docs/hard-cases.md".to_owned(),
        Err(reason) => format!("hard cases: not written: {reason}"),
    };
    let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("\n{told}\n"));
}
