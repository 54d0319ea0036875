//! `shaders/kernel/lab_importance.wesl`: mean and variance by each of the lecture's densities.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt::low_level::reference::exact::lecture::LinearDensity;
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::importance::{ROWS, checks, draw};
use direkt_instruments::lab::layout::merged;

const SETTINGS: Settings = Settings {
    samples: 1 << 20,
    seed: 51,
    density_scale: 1.0,
};

#[test]
fn means_and_variances_are_exact_and_others_are_rejected() {
    let context = context();
    let bench = Bench::new(context, "lab_importance").unwrap();
    for (row, stream) in ROWS.iter().zip(10..) {
        let blocks = draw(&bench, &SETTINGS, row.density, row.density, stream).unwrap();
        let found = merged(&blocks);
        for check in checks(row, &found) {
            accept(check.p_value, &format!("{check:?}, seed 51"));
        }
        // The variance of another row is rejected.
        for other in ROWS.iter().filter(|r| r.name != row.name) {
            let p = checks(other, &found)[1].p_value;
            reject(p, &format!("samples of {} as of {}", row.name, other.name));
        }
    }
}

/// 2 % too large a density, and one that is not that of the samples.
#[test]
fn wrong_densities_are_rejected() {
    let context = context();
    let bench = Bench::new(context, "lab_importance").unwrap();
    for row in &ROWS {
        let LinearDensity { constant, slope } = row.density;
        let larger = LinearDensity {
            constant: 1.02 * constant,
            slope: 1.02 * slope,
        };
        let found = merged(&draw(&bench, &SETTINGS, row.density, larger, 20).unwrap());
        reject(
            checks(row, &found)[0].p_value,
            &format!("{} scaled", row.name),
        );
    }
    let [falling, uniform, ..] = ROWS;
    let found = merged(&draw(&bench, &SETTINGS, falling.density, uniform.density, 21).unwrap());
    reject(checks(&uniform, &found)[0].p_value, "another density");
}
