//! `shaders/kernel/loop_canary.wesl`. What it counts on this adapter is tested in
//! `tests/doctor.rs`.

use crate::support::context;
use crate::support::shader::{Function, call};

/// The least budget known is 65,535 iterations of all loops of an invocation. What stays below it
/// runs to its end, on every driver: the render's dispatches rest on this.
#[test]
fn loops_below_the_least_budget_run_to_their_end() {
    let function = Function {
        imports: "",
        body: "let step = in_u32(0u);
               var single = 0u;
               for (var i = 0u; i < 30000u; i += step) {
                   single += 1u + (i & (step - 1u));
               }
               var nested = 0u;
               for (var i = 0u; i < 30u; i += step) {
                   for (var j = 0u; j < 1000u; j += step) {
                       nested += 1u + (j & (step - 1u));
                   }
               }
               out_u32(0u, single);
               out_u32(1u, nested);",
        inputs: 1,
        outputs: 2,
        features: &[],
    };
    let context = context();
    let answers = call(context, &function, &[1; 100]);
    for (single, nested) in answers.u32(0).zip(answers.u32(1)) {
        assert_eq!([single, nested], [30_000; 2], "{:?}", context.adapter);
    }
}
