//! `shaders/lab/rules.wesl`.

use crate::support::context;
use crate::support::shader::{Function, call};
use direkt_instruments::lab::rules::Rule;

#[test]
fn nodes_and_weights_are_those_of_f64() {
    let context = context();
    let function = Function {
        imports: "import package::lab::rules::{rule_node, rule_nodes};",
        body: "out_vec2f(0u, rule_node(in_u32(0u), in_u32(1u), in_u32(2u)));
               out_u32(2u, rule_nodes(in_u32(0u), in_u32(1u)));",
        inputs: 3,
        outputs: 3,
        features: &[],
    };
    for (rule, number) in Rule::ALL.into_iter().zip(0_u32..) {
        for panels in [1, 2, 3, 7, 64] {
            let points = rule.points(panels);
            let count = points.len() as u32;
            let items: Vec<u32> = (0..count).flat_map(|i| [number, panels, i]).collect();
            let answers = call(context, &function, &items);
            for ((found, nodes), (x, weight)) in answers.vec2(0).zip(answers.u32(2)).zip(points) {
                let what = format!("{rule:?}, {panels} panels, at {x}");
                assert_eq!(nodes, count, "{what}");
                assert!((found.x - x).abs() < 4e-7, "{what}: {found}");
                let due = weight * f64::from(count);
                assert!((found.y - due).abs() < 1e-6 * due, "{what}: {found} {due}");
            }
        }
    }
}
