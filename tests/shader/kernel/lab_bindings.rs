//! `shaders/kernel/lab_bindings.wesl`: which random number goes where, and that a run does not
//! depend on how it is cut.

use crate::support::context;
use direkt::low_level::reference::core::rng::{pcg4d, to_unit};
use direkt_instruments::lab::bench::Bench;
use direkt_instruments::lab::layout::LabRun;

/// By the uniform density 1/4 a sample is 16(1 − u): the number u itself, to f32.
#[test]
fn numbers_are_those_of_item_index_stream_and_seed() {
    let context = context();
    let bench = Bench::new(context, "lab_importance").unwrap();
    let run = LabRun {
        items: 1000,
        first_item: 77,
        samples: 1,
        seed: 5,
        stream: 9,
        constants: [0.25, 0.0, 0.25, 0.0],
        ..LabRun::default()
    };
    let blocks = bench.run(&run, &[]).unwrap().blocks;
    for (block, item) in blocks.iter().zip(77..) {
        let expected = 16.0 * (1.0 - to_unit(pcg4d([item, 0, 9, 5])[0]));
        let found = f64::from(block.mean);
        // A square root, a division and a product.
        assert!(
            (found - expected).abs() <= 8.0 * f64::from(f32::EPSILON) * expected,
            "{}: item {item}: {found} for {expected}",
            context.adapter.name
        );
        assert_eq!((block.samples, block.tries), (1, 1));
    }
}

#[test]
fn a_run_does_not_depend_on_how_it_is_cut() {
    let context = context();
    let bench = Bench::new(context, "lab_importance").unwrap();
    // 20,000 · 256 samples are more than one dispatch.
    let whole = LabRun {
        items: 20_000,
        samples: 256,
        seed: 6,
        constants: [0.125, 0.0625, 0.125, 0.0625],
        ..LabRun::default()
    };
    let all = bench.run(&whole, &[]).unwrap().blocks;
    assert_eq!(all.len(), 20_000);
    let part = LabRun {
        items: 100,
        first_item: 16_333,
        ..whole
    };
    assert_eq!(
        bench.run(&part, &[]).unwrap().blocks,
        all[16_333..16_433],
        "{}",
        context.adapter.name
    );
}
