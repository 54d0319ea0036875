//! `shaders/lab/densities.wesl`.

use crate::support::context;
use crate::support::shader::{Function, call};
use direkt_instruments::lab::densities::DENSITIES;

const FUNCTION: Function<'_> = Function {
    imports: "import package::lab::densities::{sample_density, pdf_density, density_box, density_low};",
    body: "let density = in_u32(1u);
           let x = sample_density(in_f32(0u), density);
           out_f32(0u, x);
           out_f32(1u, pdf_density(x, density));
           out_vec2f(2u, density_box(density));
           out_f32(4u, density_low(density));",
    inputs: 2,
    outputs: 5,
    features: &[],
};

#[test]
fn samples_invert_the_distribution_function_and_densities_are_those_of_f64() {
    let context = context();
    let tiny = (-24_f64).exp2();
    let numbers: Vec<f64> = [0.5 * tiny, tiny, 0.5, 1.0 - tiny]
        .into_iter()
        .chain((1..500).map(|i| f64::from(i) / 500.0))
        .map(|u| f64::from(u as f32))
        .collect();
    for (density, number) in DENSITIES.iter().zip(0_u32..) {
        let items: Vec<u32> = numbers
            .iter()
            .flat_map(|&u| [(u as f32).to_bits(), number])
            .collect();
        let answers = call(context, &FUNCTION, &items);
        let [low, high] = density.interval;
        for ((x, pdf), &u) in answers.f64(0).zip(answers.f64(1)).zip(&numbers) {
            let place = format!(
                "{}: {} at u = {u}, x = {x}",
                context.adapter.name, density.name
            );
            assert!(x >= low - 1e-6 && x <= high + 1e-6, "{place}");
            // WGSL grants log an absolute 2⁻²¹ near 1; everything else is closer.
            assert!(((density.cdf)(x) - u).abs() < 2e-6, "{place}");
            let due = (density.pdf)(x);
            assert!(
                (pdf - due).abs() < 2e-6 * density.largest,
                "{place}: {pdf} {due}"
            );
        }
        let [length, largest] = [2, 3].map(|i| answers.f64(i).next().unwrap());
        assert!(
            (length - (high - low)).abs() < 1e-6
                && (answers.f64(4).next().unwrap() - low).abs() < 1e-9
        );
        assert!((largest / density.largest - 1.0).abs() < 1e-6);
    }
}
