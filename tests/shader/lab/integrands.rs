//! `shaders/lab/integrands.wesl`.

use crate::support::context;
use crate::support::random::Random;
use crate::support::shader::{Function, call};

#[test]
fn values_are_those_of_f64_in_every_dimension() {
    let function = Function {
        imports: "import package::lab::integrands::{Point6, smooth_integrand, box_integrand};",
        body: "let p = Point6(in_vec3f(0u), in_vec3f(3u));
               let corner = Point6(in_vec3f(6u), in_vec3f(9u));
               out_f32(0u, smooth_integrand(p, in_u32(12u)));
               out_f32(1u, box_integrand(p, corner));",
        inputs: 13,
        outputs: 2,
        features: &[],
    };
    let mut random = Random::new(58);
    let mut cases: Vec<(u32, [f64; 12])> = Vec::new();
    for dimensions in 1..=6_u32 {
        for _ in 0..200 {
            let mut values = [0.0; 12];
            for axis in 0..6 {
                let used = axis < dimensions as usize;
                values[axis] = if used { random.uniform() } else { 0.0 };
                values[6 + axis] = if used { random.between(0.5, 1.0) } else { 1.0 };
            }
            cases.push((dimensions, values));
        }
    }
    let items: Vec<u32> = cases
        .iter()
        .flat_map(|(s, v)| v.iter().map(|&x| (x as f32).to_bits()).chain([*s]))
        .collect();
    let answers = call(context(), &function, &items);
    for ((s, v), (smooth, inside)) in cases.iter().zip(answers.f64(0).zip(answers.f64(1))) {
        let sum: f64 = v[..6].iter().sum();
        let due = (2.0 / 2_f64.exp_m1()).powi(*s as i32) * (2.0 * sum).exp();
        // 3 + 2|x| ulp of the exponential and the roundings of its argument, up to 12.
        assert!(
            (smooth / due - 1.0).abs() < 60.0 * f64::from(f32::EPSILON),
            "{s} {v:?}"
        );
        let all = (0..6).all(|i| v[i] < v[6 + i]);
        assert_eq!(inside, if all { 1.0 } else { 0.0 }, "{s} {v:?}");
    }
}
