//! `shaders/lab/welford.wesl`.

use crate::support::context;
use crate::support::shader::{Function, call};
use direkt::low_level::reference::core::rng::{pcg4d, to_unit};
use direkt::low_level::stats::moments::Moments;

#[test]
fn blocks_of_256_have_mean_and_spread_of_f64() {
    let function = Function {
        imports: "import package::lab::welford::{empty_block, push_value};
                  import package::core::rng::{pcg4d, to_unit};",
        body: "var block = empty_block();
               for (var i = 0u; i < 256u; i++) {
                   block = push_value(block, 100.0 + to_unit(pcg4d(vec4u(in_u32(0u), i, 0u, 0u)).x), 2u);
               }
               out_f32(0u, block.mean);
               out_f32(1u, block.m2);
               out_u32(2u, block.samples);
               out_u32(3u, block.tries);",
        inputs: 1,
        outputs: 4,
        features: &[],
    };
    let items: Vec<u32> = (0..200).collect();
    let answers = call(context(), &function, &items);
    for item in 0..200 {
        let values = (0..256).map(|i| 100.0 + to_unit(pcg4d([item, i, 0, 0])[0]));
        let due: Moments = values.map(|v| f64::from(v as f32)).collect();
        let at = item as usize;
        let (mean, m2) = (
            answers.f64(0).nth(at).unwrap(),
            answers.f64(1).nth(at).unwrap(),
        );
        // 256 roundings of numbers below 101, and of products of deviations below 1 with an error
        // of the mean.
        let ulp = 101.0 * f64::from(f32::EPSILON);
        assert!((mean - due.mean).abs() < 256.0 * 0.5 * ulp);
        assert!((m2 - due.m2).abs() < 256.0 * 2.0 * ulp, "{m2} {}", due.m2);
        assert_eq!(answers.u32(2).nth(at), Some(256));
        assert_eq!(answers.u32(3).nth(at), Some(512));
    }
}
