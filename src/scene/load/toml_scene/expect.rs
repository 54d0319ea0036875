//! The `[expect]` table.

use super::build::Context;
use super::format::ExpectTable;
use crate::error::InputError;
use crate::scene::rgb::Rgb;
use crate::scene::{Expect, ExpectedRadiance, FilmSize};
use glam::DVec3;

/// What an image of size `film` must be.
pub(super) fn expect(
    context: &Context,
    table: ExpectTable,
    film: FilmSize,
) -> Result<Expect, InputError> {
    let radiance = match (table.radiance, table.pixels) {
        (Some(mean), None) => ExpectedRadiance::Mean(DVec3::from_array(mean.0)),
        (None, Some(rows)) => ExpectedRadiance::Pixels(pixels(context, &rows, film)?),
        _ => {
            return Err(context.error(
                "expect",
                "the image is given twice or not at all",
                "`radiance` (its mean) or `pixels`",
            ));
        }
    };
    Ok(Expect {
        radiance,
        source: table.source,
        tolerance: table.tolerance,
    })
}

fn pixels(context: &Context, rows: &[Vec<Rgb>], film: FilmSize) -> Result<Vec<DVec3>, InputError> {
    if rows.len() != film.height as usize {
        return Err(context.error(
            "expect.pixels",
            format!("has {} rows", rows.len()),
            format!("{}, the film's height", film.height),
        ));
    }
    for (y, row) in rows.iter().enumerate() {
        if row.len() != film.width as usize {
            return Err(context.error(
                format!("expect.pixels[{y}]"),
                format!("has {} values", row.len()),
                format!("{}, the film's width", film.width),
            ));
        }
    }
    let values = rows.iter().flatten();
    Ok(values.map(|rgb| DVec3::from_array(rgb.0)).collect())
}
