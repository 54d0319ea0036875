//! `shaders/core/stratified.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::shader::{Function, call};
use direkt::low_level::reference::core::stratified::stratified_2d;

/// Bit for bit the twin's, and every cell of the grid once, whatever its shape.
#[test]
fn every_cell_holds_one_point() {
    let context = context();
    let mut random = Random::new(63);
    let function = Function {
        imports: "import package::core::stratified::stratified_2d;",
        body: "let p = stratified_2d(in_u32(0u), vec2u(in_u32(1u), in_u32(2u)), in_u32(3u), vec2u(in_u32(4u), in_u32(5u)));
               out_u32(0u, p.x);
               out_u32(1u, p.y);",
        inputs: 6,
        outputs: 2,
        features: &[],
    };
    for bits in [[0, 0], [1, 0], [3, 3], [4, 3], [0, 5], [8, 8]] {
        let cells = 1_u32 << (bits[0] + bits[1]);
        let seed = random.word();
        let items: Vec<[u32; 6]> = (0..cells)
            .map(|i| [i, bits[0], bits[1], seed, random.word(), random.word()])
            .collect();
        let inputs: Vec<u32> = items.iter().flatten().copied().collect();
        let answers = call(context, &function, &inputs);
        let mut hits = vec![0; cells as usize];
        for (item, (x, y)) in items.iter().zip(answers.u32(0).zip(answers.u32(1))) {
            let expected = stratified_2d(item[0], bits, seed, [item[4], item[5]]);
            assert_eq!([x, y], expected, "{item:?}");
            let column = u64::from(x) >> (32 - bits[0]);
            let row = u64::from(y) >> (32 - bits[1]);
            hits[(row << bits[0] | column) as usize] += 1;
        }
        assert!(hits.iter().all(|&h| h == 1), "{bits:?}");
    }
}
