//! `shaders/kernel/lab_quadrature.wesl`: what rules give, exactly, and what random points give, in
//! the mean.

use crate::support::context;
use crate::support::statistics::{accept, reject};
use direkt::low_level::stats::moments::Moments;
use direkt::low_level::stats::t_test::one_sample;
use direkt_instruments::lab::Settings;
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::integral::{Case, Measured, Method, ladder};
use direkt_instruments::lab::rules::Integrand;

const SETTINGS: Settings = Settings {
    samples: 1 << 20,
    seed: 56,
    density_scale: 1.0,
};

#[test]
fn rules_give_their_closed_forms() {
    let context = context();
    let bench = Bench::new(context, "lab_quadrature").unwrap();
    let wrong = Settings {
        density_scale: 1.02,
        ..SETTINGS
    };
    for integrand in Integrand::ALL {
        for method in &Method::ALL[..4] {
            for dimensions in [1, 2, 3, 6] {
                let case = ladder(integrand, *method, dimensions)[0];
                let off = |settings| Measured::new(&bench, settings, case).unwrap().off;
                assert!(off(&SETTINGS) <= case.allowance(), "{case:?}");
                assert!(off(&wrong) > case.allowance(), "{case:?}: 2 % too large");
            }
        }
    }
}

#[test]
fn random_points_are_right_in_the_mean_and_two_percent_more_is_not() {
    let context = context();
    let bench = Bench::new(context, "lab_quadrature").unwrap();
    for integrand in Integrand::ALL {
        for method in &Method::ALL[4..] {
            for dimensions in 1..=6 {
                let case = Case {
                    integrand,
                    method: *method,
                    dimensions,
                    size: 1 << 14,
                };
                let measured = Measured::new(&bench, &SETTINGS, case).unwrap();
                let exact = (0..).map(|i| integrand.integral(&case.corner(56, i)));
                let pairs = measured.errors.iter().zip(exact);
                let errors: Vec<(f64, f64)> = pairs.map(|(e, i)| (*e, i)).collect();
                let p = |scale: f64| {
                    let all: Moments = errors
                        .iter()
                        .map(|(e, i)| scale * (e + i) / i - 1.0)
                        .collect();
                    // What rounding may add is far below the spread of all but Sobol points of one
                    // dimension.
                    if (all.mean).abs() < case.allowance() {
                        return 1.0;
                    }
                    one_sample(&all, 0.0).unwrap().p_value
                };
                let what = format!("{case:?}, seed 56");
                accept(p(1.0), &what);
                reject(p(1.02), &what);
            }
        }
    }
}
