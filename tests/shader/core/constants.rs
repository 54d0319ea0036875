//! `shaders/core/constants.wesl`.

use crate::support::context;
use crate::support::shader::{Function, draw};
use std::f32::consts::PI;

/// Each is the f32 nearest to the number that it stands for.
#[test]
fn constants_are_the_nearest_f32() {
    let context = context();
    let function = Function {
        imports: "import package::core::constants::{INV_PI, INV_TWO_PI, NONE, PI, T_MAX, TWO_PI};",
        body: "out_f32(0u, PI);
               out_f32(1u, INV_PI);
               out_f32(2u, TWO_PI);
               out_f32(3u, INV_TWO_PI);
               out_f32(4u, T_MAX);
               out_u32(5u, NONE);",
        inputs: 0,
        outputs: 6,
        features: &[],
    };
    let answers = draw(context, &function, 1);
    let numbers = [
        PI,
        std::f32::consts::FRAC_1_PI,
        std::f32::consts::TAU,
        (0.5 * std::f64::consts::FRAC_1_PI) as f32,
        1e30,
    ];
    for (i, number) in numbers.into_iter().enumerate() {
        let got = answers.u32(i).next();
        assert_eq!(
            got,
            Some(number.to_bits()),
            "{}: {number}",
            context.adapter.name
        );
    }
    assert_eq!(answers.u32(5).next(), Some(u32::MAX));
}
