//! `shaders/kernel/filter.wesl`.

use crate::support::rounding::U;
use crate::support::shader::{Function, call_in, words};
use crate::support::{context, edge_points, floor_pixel, histogram, prepared, statistics};
use direkt::low_level::gpu::Context;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::reference::BrokenTwin;
use direkt::low_level::reference::exact::cubature::{Tolerance, integrate};
use direkt::low_level::reference::kernel::filter::{film_point, sample_filter, sample_in_cell};
use direkt::scene::PixelFilter;
use direkt::scene::filter::FilterKind;
use glam::{DVec2, DVec3};

/// Filters of every kind, and a Gaussian that ends long before its radius.
fn filters() -> Vec<PixelFilter> {
    use clap::ValueEnum;
    let kinds = FilterKind::value_variants().iter();
    let mut filters: Vec<_> = kinds.map(|k| PixelFilter::of_kind(*k)).collect();
    filters[0].radius = 1.25;
    filters.push(PixelFilter {
        radius: 8.0,
        ..PixelFilter::of_kind(FilterKind::Gaussian)
    });
    filters
}

fn with(filter: PixelFilter) -> Prepared {
    let mut scene = floor_pixel();
    scene.filter = filter;
    prepared(scene)
}

fn film_points(context: &Context, prepared: &Prepared, numbers: &[DVec2]) -> Vec<DVec2> {
    let function = Function {
        imports: "import package::kernel::filter::film_point;",
        body: "out_vec2f(0u, film_point(vec2u(0u), in_vec2f(0u)));",
        inputs: 2,
        outputs: 2,
        features: &[],
    };
    let inputs: Vec<f64> = numbers.iter().flat_map(DVec2::to_array).collect();
    let answers = call_in(context, prepared, &function, &words(&inputs), numbers.len());
    answers.vec2(0).collect()
}

/// How far `found` is beyond what rounding explains, 0 where it is not.
///
/// The quotient that places a number in its cell is off by 6 U, so that the answer lies between
/// those of numbers as far away; what comes then has 30 roundings of its own, and ½ and the pixel
/// are added, with one of the sum.
fn excess(prepared: &Prepared, u: f64, found: f64) -> f64 {
    let table = prepared.data.scene.filter.table();
    let distance = (2.0 * u - 1.0).abs();
    let cell = table
        .knots
        .windows(2)
        .find(|k| f64::from(k[1][0]) > distance);
    let mass = cell.map_or(0.0, |k| f64::from(k[1][0] - k[0][0]));
    // Half of what moves the distance; the ends stay in the unit interval.
    let off = 3.0 * U * mass.max(U);
    let ends = [u - off, u + off].map(|u| sample_filter(&table, u.clamp(0.0, 1.0)));
    let own = 30.0 * U * f64::from(table.cell_width) + 2.0 * U * (found.abs() + 1.0);
    let middle = found - 0.5;
    (ends[0].min(ends[1]) - own - middle)
        .max(middle - ends[0].max(ends[1]) - own)
        .max(0.0)
}

#[test]
fn film_points_are_the_twins() {
    let context = context();
    let numbers = edge_points();
    for filter in filters() {
        let prepared = with(filter);
        let points = film_points(context, &prepared, &numbers);
        for (u, p) in numbers.iter().zip(&points) {
            let expected = film_point(&filter.table(), DVec2::ZERO, *u);
            for i in 0..2 {
                let excess = excess(&prepared, u[i], p[i]);
                assert!(
                    excess <= 0.0,
                    "{}, {filter:?}: {u} goes to {p}, not {expected}; {excess:e} beyond rounding",
                    context.adapter.name
                );
                assert!(
                    (p[i] - 0.5).abs() <= filter.radius * (1.0 + 4.0 * U),
                    "{filter:?}: {p}"
                );
            }
        }
        let broken = with(PixelFilter {
            radius: 1.01 * filter.radius,
            stddev: 1.01 * filter.stddev,
            ..filter
        });
        let told = numbers
            .iter()
            .zip(&points)
            .any(|(u, p)| excess(&broken, u.x, p.x) > 0.0);
        assert!(told, "{filter:?}: a filter that is 1 % wider passes");
    }
}

/// The whole pixel, each point alike: what would be drawn without a filter.
#[test]
fn the_pixels_own_square_changes_nothing() {
    let context = context();
    let mut prepared = with(PixelFilter::default());
    let reason = || "forced".to_owned();
    prepared
        .effects
        .call_for(direkt::low_level::effects::Effect::PixelFilter, reason);
    let numbers = edge_points();
    assert_eq!(film_points(context, &prepared, &numbers), numbers);
}

#[test]
fn positions_in_a_cell_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::kernel::filter::sample_in_cell;",
        body: "out_f32(0u, sample_in_cell(in_f32(0u), in_f32(1u), in_f32(2u)));",
        inputs: 3,
        outputs: 1,
        features: &["PIXEL_FILTER"],
    };
    let cells = [
        [1.0, 1.0],
        [1.0, 0.0],
        [1.0, 0.97],
        [1e-6, 0.0],
        [1e-6, 9e-7],
    ];
    let numbers = edge_points();
    let items = cells
        .iter()
        .flat_map(|[a, b]| numbers.iter().map(move |u| [u.x, *a, *b]));
    let items: Vec<[f64; 3]> = items.map(|i| i.map(|x| f64::from(x as f32))).collect();
    let inputs: Vec<f64> = items.iter().flatten().copied().collect();
    let prepared = with(PixelFilter::default());
    let answers = call_in(context, &prepared, &function, &words(&inputs), items.len());
    for ([u, a, b], found) in items.iter().zip(answers.f64(0)) {
        let expected = sample_in_cell(*u, *a, *b);
        // A sum and a product below, 9 U of the root and 5 U of the quotient; the root of 1 − u is
        // exact in u.
        assert!(
            (found - expected).abs() <= 20.0 * U * expected,
            "u = {u}, {a} to {b}: {found:e}, not {expected:e}"
        );
        // What it inverts.
        let back = expected * (a + 0.5 * expected * (b - a)) / (0.5 * (a + b));
        assert!((back - u).abs() <= 1e-14, "{u} comes back as {back}");
    }
}

/// Against the filter itself, not against the table: the noise of a million samples is far above
/// what the table leaves of it.
#[test]
fn film_points_match_their_filter() {
    let context = context();
    for filter in filters() {
        let prepared = with(filter);
        let numbers: Vec<DVec2> = (0..1 << 20)
            .map(|i| {
                let [x, y, ..] = crate::support::random::numbers(i, 5, 77);
                DVec2::new(x, y)
            })
            .collect();
        let samples: Vec<DVec2> = film_points(context, &prepared, &numbers)
            .into_iter()
            .map(|p| p - 0.5)
            .collect();
        let tolerance = Tolerance {
            absolute: 1e-9,
            relative: 0.0,
        };
        let reach = filter.radius.min(4.0);
        let cut = [0.0, reach];
        let along = |x: f64, _: f64| DVec3::splat(filter.value(x));
        let half = integrate(along, &cut, &[0.0, 1.0], tolerance).value.x;
        let pdf = |p: DVec2| {
            let at = |x: f64| filter.value(x.abs()) / (2.0 * half);
            at(p.x) * at(p.y)
        };
        let what = format!("film_point, {filter:?}, seed 77, {}", context.adapter.name);
        let (low, high) = (DVec2::splat(-reach), DVec2::splat(reach));
        let test = |pdf: &dyn Fn(DVec2) -> f64| histogram::p_value(&samples, low, high, pdf);
        statistics::accept(test(&pdf), &what);
        statistics::reject_broken(&what, |twin| match twin {
            BrokenTwin::PdfScaled => Some(test(&|p| 1.02 * pdf(p))),
            BrokenTwin::WrongMeasure => Some(test(&|p| pdf(1.02 * p))),
            _ => None,
        });
    }
}
