//! Every sampler at the borders of the unit square: HARD CASES S1.

use crate::support::context;
use crate::support::hard_cases::{Measured, survive};
use crate::support::shader::{Function, call};

const IMPORTS: &str = "import package::bsdf::ggx::sample_ggx_visible_normal;
    import package::bsdf::lambert::{sample_lambert, sample_uniform_hemisphere};
    import package::core::rng::to_unit_2d;
    import package::light::disk::sample_disk_area;
    import package::light::environment::sample_environment_cell;
    import package::light::polygon::{MAX_VERTICES, project_polygon, sample_projected_polygon};
    import package::light::rectangle::{
        sample_parallelogram_solid_angle, sample_rectangle_area, sample_rectangle_solid_angle,
        spherical_parallelogram, spherical_rectangle
    };
    import package::light::sphere::{cone_height, sample_cone, sample_sphere_area};
    import package::light::triangle::{sample_triangle_area, sample_triangle_solid_angle, spherical_triangle};
    const Z = vec3f(0.0, 0.0, 1.0);
    const X = vec3f(1.0, 0.0, 0.0);
    const Y = vec3f(0.0, 1.0, 0.0);
    fn projected(u: vec2f) -> vec3f {
        var v: array<vec3f, MAX_VERTICES>;
        v[0] = Z; v[1] = Z + X; v[2] = Z + X + Y; v[3] = Z + Y;
        return sample_projected_polygon(project_polygon(v, 4u), u);
    }
    fn in_triangle(u: vec2f) -> vec3f {
        let t = spherical_triangle(vec3f(0.0), Z, X, Y);
        return sample_triangle_solid_angle(t, u.x * t.solid_angle, u.y);
    }
    // Normals with the density D cosθ: tan²θ = α²u/(1 − u).
    fn textbook(u: vec2f) -> vec3f {
        let tan2 = 0.01 * u.x / (1.0 - u.x);
        let c = 1.0 / sqrt(1.0 + tan2);
        return vec3f(sqrt(tan2) * c * cos(6.28318531 * u.y), sqrt(tan2) * c * sin(6.28318531 * u.y), c);
    }";

/// Each sampler's point or direction, then the textbook's for the word over 2³².
const BODY: &str = "let w = vec2u(in_u32(0u), in_u32(1u));
    let u = to_unit_2d(w);
    out_vec3f(0u, sample_lambert(u));
    out_vec3f(3u, sample_uniform_hemisphere(u));
    out_vec3f(6u, sample_ggx_visible_normal(normalize(vec3f(1.0, 0.5, 1e-4)), 1e-4, u));
    out_vec3f(9u, vec3f(sample_disk_area(u), 0.0));
    out_vec3f(12u, vec3f(sample_triangle_area(u), 0.0));
    out_vec3f(15u, vec3f(sample_rectangle_area(u), 0.0));
    out_vec3f(18u, sample_sphere_area(u));
    out_vec3f(21u, sample_cone(Z, cone_height(1e-4), u).xyz);
    out_vec3f(24u, in_triangle(u));
    out_vec3f(27u, sample_rectangle_solid_angle(spherical_rectangle(vec3f(0.0), Z, X, Y), u).wi);
    out_vec3f(30u, sample_parallelogram_solid_angle(spherical_parallelogram(vec3f(0.0), Z, X, X + Y), u));
    out_vec3f(33u, projected(u));
    out_vec3f(36u, sample_environment_cell(vec2u(0u, 0u), vec2u(16u, 8u), u));
    out_vec3f(39u, textbook(vec2f(w) * 2.3283064365386963e-10));";

const SAMPLERS: usize = 13;

#[test]
fn samplers_are_finite_at_the_borders_of_the_square() {
    let context = context();
    let function = Function {
        imports: IMPORTS,
        body: BODY,
        inputs: 2,
        outputs: 3 * (SAMPLERS + 1),
        features: &[],
    };
    let words = [0, 0x100, 0x8000_0000, 0xffff_ff00, 0xffff_ff80, 0xffff_ffff];
    let inputs: Vec<u32> = words
        .iter()
        .flat_map(|&x| words.iter().flat_map(move |&y| [x, y]))
        .collect();
    let answers = call(context, &function, &inputs);
    let broken = |sampler: usize| answers.vec3(3 * sampler).filter(|v| !v.is_finite()).count();
    survive(
        context,
        Measured {
            entry: "S1",
            case: "13 samplers at numbers from 0 to 1 − 2⁻²⁴",
            figure: "samples that are not finite",
            bound: 0.0,
            textbook: "the word over 2³², and tan²θ = α²u/(1 − u)",
            naive: broken(SAMPLERS) as f64,
            ours: (0..SAMPLERS).map(broken).sum::<usize>() as f64,
        },
    );
}
