//! The page: everything in one HTML file.

use super::effects;
use super::figures::{self, ranked};
use super::format::{escape, grouped, number, range, seconds};
use super::lead::lead;
use super::machine::Machine;
use super::picture::{heat_map, radiance};
use super::tables::{equal_error, not_applicable, ranking, vague};
use crate::cost::reference::Source;
use crate::cost::{EqualTime, EstimatorCost, SceneCost};
use crate::drawing::svg::adaptive_css;
use direkt::error::Error;
use direkt::low_level::image::heat::{HEAT, heat};
use direkt::scene::FilmSize;

const STYLE: &str = include_str!("style.css");
/// Pixels per row that an image is shown with on a wide screen.
const SHOWN_WIDTH: u32 = 304;

/// The page for all scenes; those of `not_measured` are named.
pub fn html(
    costs: &[SceneCost],
    not_measured: &[String],
    machine: &Machine,
) -> Result<String, Error> {
    let sections: Result<Vec<_>, _> = costs.iter().map(section).collect();
    let driver = &machine.adapter;
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>What accuracy costs in time</title>\n\
         <style>{STYLE}{}</style></head><body>\n<header><h1>What accuracy costs in time</h1>\n\
         <p class=\"faint\">direct lighting by direkt {} on {}{}</p></header>\n<main>\n{}{}</main>\n{}</body></html>\n",
        adaptive_css(),
        escape(machine.direkt),
        escape(&driver.name),
        if driver.software {
            ", a GPU in software"
        } else {
            ""
        },
        sections?.concat(),
        interrupted_before(not_measured),
        footer(machine),
    ))
}

/// Which scenes there is no result of, in a sentence; empty where there are none.
fn interrupted_before(not_measured: &[String]) -> String {
    if not_measured.is_empty() {
        return String::new();
    }
    let names: Vec<_> = not_measured.iter().map(|n| escape(n)).collect();
    format!(
        "<section><p>Interrupted before there was a result for {}.</p></section>\n",
        names.join(", ")
    )
}

fn section(cost: &SceneCost) -> Result<String, Error> {
    let [time, samples, efficiency] = figures::of(cost).map(|f| f.svg.inline());
    let (name, lead) = (escape(&cost.scene), lead(cost));
    let facts = facts(cost);
    Ok(format!(
        "<section>\n<h2>{name}</h2>\n<p class=\"lead\">{lead}</p>\n<p class=\"faint\">{facts}</p>\n\
         <h3>Error against time</h3>\n<figure class=\"wide\">{time}</figure>\n\
         <h3>Efficiency</h3>\n<figure class=\"wide\">{efficiency}</figure>\n\
         <h3>Error against samples</h3>\n<figure class=\"wide\">{samples}</figure>\n\
         <h3>Ranking</h3>\n{}<p class=\"faint\">= marks ties: estimators whose intervals of efficiency overlap{}. ≈ is \
         extrapolated along the fitted line. Intervals hold with 95 % confidence; slopes have standard errors.</p>\n{}\
         {}{}<h3>What the same error costs</h3>\n{}{}</section>\n",
        ranking(cost),
        effects::ties(cost),
        vague(cost),
        effects::section(cost),
        equal_time(cost)?,
        equal_error(cost),
        not_applicable(cost),
    ))
}

fn facts(cost: &SceneCost) -> String {
    let own = cost.reference.rel_mse.map_or_else(
        || "its own error is not known and was not subtracted".to_owned(),
        |e| {
            if e.value > 0.0 {
                let interval = range(&e, number);
                format!(
                    "its own relMSE of {} {interval} was subtracted",
                    number(e.value)
                )
            } else {
                "without error".to_owned()
            }
        },
    );
    let reference = match &cost.reference.source {
        Source::File { path } => escape(path),
        Source::Exact { source } => format!("the scene's exact values ({})", escape(source)),
        Source::OwnRun {
            estimator,
            samples,
            seconds: s,
        } => format!(
            "{estimator}, {} samples per pixel in {}, other seeds",
            grouped(*samples as f64),
            seconds(*s)
        ),
    };
    format!(
        "{} × {} pixels · {} primitives · {} of rendering{} · reference: {reference}; {own}",
        cost.width,
        cost.height,
        grouped(cost.primitives as f64),
        seconds(cost.seconds),
        if cost.interrupted {
            format!(
                ", <b>interrupted</b> before the {} that were allowed",
                seconds(cost.budget)
            )
        } else {
            String::new()
        },
    )
}

fn size(cost: &SceneCost) -> FilmSize {
    FilmSize {
        width: cost.width,
        height: cost.height,
    }
}

/// Class of images that are shown enlarged.
fn pixels(cost: &SceneCost) -> &'static str {
    if cost.width < SHOWN_WIDTH {
        " class=\"pixels\""
    } else {
        ""
    }
}

/// What a lecture's slide says below an image, in two lines.
fn stamp(cost: &SceneCost, e: &EqualTime) -> String {
    let passes = if e.passes == 1 { "pass" } else { "passes" };
    format!(
        "{} · {} {passes} · {} primitives<br>{:.1} M rays/s",
        seconds(e.seconds),
        grouped(e.passes as f64),
        grouped(cost.primitives as f64),
        e.rays_per_second / 1e6
    )
}

/// Estimators that have an image at equal time, with it, best first.
fn at_equal_time(cost: &SceneCost) -> impl Iterator<Item = (&EstimatorCost, &EqualTime)> {
    let ranked = ranked(cost).into_iter();
    ranked.filter_map(|e| Some((e, e.equal_time.as_ref()?)))
}

/// Images at equal time and where their error is; empty where measuring ended before.
fn equal_time(cost: &SceneCost) -> Result<String, Error> {
    if at_equal_time(cost).next().is_none() {
        return Ok(String::new());
    }
    Ok(format!(
        "<h3>What {} of rendering give</h3>\n<div class=\"images\">{}</div>\n\
         <h3>Where the error is</h3>\n{}<div class=\"images\">{}</div>\n",
        seconds(cost.equal_seconds),
        images(cost)?,
        heat_legend(),
        heat_maps(cost)?,
    ))
}

fn images(cost: &SceneCost) -> Result<String, Error> {
    let mut out = String::new();
    for (estimator, e) in at_equal_time(cost) {
        let image = radiance(size(cost), e.film.pixels.iter().map(|p| p.mean))?;
        let spp = grouped(e.samples as f64);
        out.push_str(&format!(
            "<figure><img{pixels} alt=\"{name}\" src=\"{image}\">\
             <figcaption><b>{name}</b>relMSE {} · {spp} samples per pixel<br>{}</figcaption></figure>\n",
            number(e.rel_mse),
            stamp(cost, e),
            name = escape(&estimator.name),
            pixels = pixels(cost),
        ));
    }
    let image = radiance(size(cost), cost.reference_image.iter().copied())?;
    out.push_str(&format!(
        "<figure><img{pixels} alt=\"reference\" src=\"{image}\"><figcaption><b>reference</b></figcaption></figure>\n",
        pixels = pixels(cost),
    ));
    Ok(out)
}

fn heat_maps(cost: &SceneCost) -> Result<String, Error> {
    let figure = |(estimator, e): (&EstimatorCost, &EqualTime)| {
        let image = heat_map(size(cost), &e.relative_errors)?;
        Ok(format!(
            "<figure><img{pixels} alt=\"error of {name}\" src=\"{image}\"><figcaption><b>{name}</b>{}</figcaption></figure>\n",
            share(&e.relative_errors),
            name = escape(&estimator.name),
            pixels = pixels(cost),
        ))
    };
    let figures: Result<Vec<String>, Error> = at_equal_time(cost).map(figure).collect();
    Ok(figures?.concat())
}

/// In how few pixels most of the error is.
fn share(errors: &[f64]) -> String {
    let mut squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    let total: f64 = squares.iter().sum();
    if total <= 0.0 {
        return "no error at all".to_owned();
    }
    let mut sum = 0.0;
    let enough = |s: &f64| {
        sum += s;
        sum >= 0.9 * total
    };
    let count = squares
        .iter()
        .position(enough)
        .map_or(squares.len(), |i| i + 1);
    let percent = 100.0 * count as f64 / squares.len() as f64;
    format!(
        "90 % of the squared error in {} % of the pixels",
        number(percent)
    )
}

fn heat_legend() -> String {
    let (low, high) = HEAT;
    let colour = |i: i32| {
        let [r, g, b] = heat(low * (high / low).powf(f64::from(i) / 12.0));
        format!("rgb({r},{g},{b})")
    };
    let colours: Vec<_> = (0..=12).map(colour).collect();
    format!(
        "<div class=\"legend\">{} %<i style=\"background:linear-gradient(90deg,{})\"></i>{} % relative error of a pixel</div>\n",
        100.0 * low,
        colours.join(","),
        100.0 * high
    )
}

fn footer(machine: &Machine) -> String {
    let cpu = machine.cpu.as_deref().unwrap_or("not told by the system");
    let adapter = &machine.adapter;
    let facts = [
        ("adapter", adapter.name.clone()),
        (
            "driver",
            format!("{} ({})", adapter.driver, adapter.backend),
        ),
        ("processor", format!("{cpu}, {} threads", machine.threads)),
        ("system", machine.system.clone()),
        ("direkt", machine.direkt.to_owned()),
    ];
    let list = |items: &[(&str, String)]| -> String {
        let item = |(term, text): &(&str, String)| {
            format!("<dt>{}</dt><dd>{}</dd>\n", escape(term), escape(text))
        };
        format!("<dl>{}</dl>\n", items.iter().map(item).collect::<String>())
    };
    let definitions = DEFINITIONS.map(|(term, text)| (term, text.to_owned()));
    format!(
        "<footer><h3>Machine and driver</h3>\n{}<h3>How it was measured</h3>\n{}</footer>\n",
        list(&facts),
        list(&definitions)
    )
}

const DEFINITIONS: [(&str, &str); 11] = [
    (
        "relMSE",
        "mean over pixels and channels of (x − r)² / (r² + 0.01·mean(r)²), x the image and r the reference, less the reference's own error where that is known",
    ),
    (
        "its interval",
        "from independent images with other seeds, at least two at each number of samples: how each pixel's squared error varies over them (tiles of 16 × 16 pixels under blue noise), with Student's t and Satterthwaite's degrees of freedom",
    ),
    (
        "time",
        "seconds of rendering alone: not compiling, not reading the image. The estimators take turns, so that drift of the machine hits all alike",
    ),
    (
        "slope",
        "of ln relMSE against ln samples or ln seconds, by weighted least squares over all counts whose error is known to a factor of two; −1 for independent samples",
    ),
    (
        "efficiency",
        "1/(V·T), V the relative variance of one sample and T its time: 1/(relMSE · seconds) at the largest number of samples; twice as efficient is the same error in half the time where errors fall as 1/time",
    ),
    (
        "rank",
        "1 plus the number of estimators whose interval of efficiency lies above; overlapping intervals are ties",
    ),
    (
        "effects",
        "“+ …”: compiled in although the scene does not call for it, ways of sampling aside. An estimator with and without has the same random numbers, so that the images are the same, which is checked in all bits of all pixels, and so are their errors at equal samples; the ratio of times is told from runs in pairs, and efficiency falls as time rises",
    ),
    (
        "biased",
        "shadow rays end at the same points of the lights in all samples: the error falls to that of this quadrature, not to zero",
    ),
    (
        "images",
        "at equal time; those wider than the page shows them are reduced, by the mean of the light that a display shows of them, which makes their noise look smaller: relMSE is that of the whole image",
    ),
    (
        "heat maps",
        "√ of each pixel's relative squared error, mean over channels, in the image at equal time; the root mean square of several pixels where they are reduced",
    ),
    (
        "curves",
        "colour is the strategy, dashes are the sampler; thin lines with crosses have unneeded effects, whose colour tells them apart where there is one strategy; whiskers are 95 % intervals",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_counts_pixels() {
        let mut errors = vec![0.0; 99];
        errors.push(3.0);
        assert_eq!(
            share(&errors),
            "90 % of the squared error in 1.00 % of the pixels"
        );
        assert_eq!(share(&[0.0]), "no error at all");
    }
}
