//! Weights of two strategies: HARD CASES M2.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::shader::{Function, draw};
use direkt::low_level::stats::moments::Moments;

/// The irradiance of a constant environment, one sample over the uniform hemisphere and one in
/// proportion to the cosine: the variance of their weighted sum is 0.43864423014204 by the balance
/// heuristic and 0.523097720493333 by the power heuristic (quadrature). 2²² samples have it to 0.1
/// %.
#[test]
fn two_strategies_have_the_exact_variance() {
    let context = context();
    let function = Function {
        imports: "import package::bsdf::lambert::{pdf_lambert, sample_lambert, sample_uniform_hemisphere};
            import package::core::constants::INV_TWO_PI;
            import package::core::pdf::{PdfSolidAngle, balance_heuristic, power_heuristic};
            import package::core::rng::{pcg4d, to_unit_2d};",
        body: "let words = pcg4d(vec4u(item, 95u, 96u, 97u));
               let uniform_pdf = PdfSolidAngle(INV_TWO_PI);
               let z = vec2f(sample_uniform_hemisphere(to_unit_2d(words.xy)).z, sample_lambert(to_unit_2d(words.zw)).z);
               let of_first = pdf_lambert(z.x);
               let of_second = pdf_lambert(z.y);
               let first = z.x / INV_TWO_PI;
               // z/(z/π), also at the horizon.
               let second = 3.14159265;
               out_f32(0u, first * balance_heuristic(uniform_pdf, of_first)
                   + second * balance_heuristic(of_second, uniform_pdf));
               out_f32(1u, first * power_heuristic(uniform_pdf, of_first)
                   + second * power_heuristic(of_second, uniform_pdf));
               out_f32(2u, 0.5 * (first + second));",
        inputs: 0,
        outputs: 3,
        features: &[],
    };
    let answers = draw(context, &function, 65_535 * 64);
    let off = |word, exact: f64| {
        let moments: Moments = answers.f64(word).collect();
        (moments.variance().unwrap() / exact - 1.0).abs()
    };
    for (word, exact, heuristic) in [
        (0, 0.438_644_230_142_04, "balance"),
        (1, 0.523_097_720_493_333, "power"),
    ] {
        survive(
            context,
            Measured {
                entry: "M2",
                case: &format!(
                    "a constant environment, uniform and by the cosine, {heuristic} heuristic"
                ),
                figure: "relative error of the variance",
                bound: 0.01,
                textbook: "weights of one half",
                naive: off(2, exact),
                ours: off(word, exact),
            },
        );
    }
}
