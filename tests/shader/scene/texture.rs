//! `shaders/scene/texture.wesl`: where texture coordinates fall on an image.

use crate::support::context;
use crate::support::random::Random;
use crate::support::shader::{Function, call, words};
use direkt::low_level::gpu::layout::NEAREST_BIT;
use direkt::low_level::reference::scene::texture::{footprint, wrap_coordinate, wrap_texel};
use direkt::scene::environment::Interpolation;
use direkt::scene::{TextureId, TextureUse, Wrap};
use glam::{DAffine2, DMat2, DVec2};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

/// Numbers of f32 from tiny to large, of both signs, and those where the image ends.
fn coordinates() -> Vec<f64> {
    let mut random = Random::new(62);
    let mut numbers = vec![
        0.0,
        0.5,
        1.0,
        1.5,
        2.0,
        -0.5,
        -1.0,
        -2.0,
        -1e-9,
        1e-9,
        0.999_999_94,
    ];
    numbers.extend((0..20_000).map(|_| random.between(-5.0, 5.0)));
    numbers.into_iter().map(|x| f64::from(x as f32)).collect()
}

/// Each of the roundings is one of a number of magnitude |x| + 1.
#[test]
fn coordinates_are_wrapped_like_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::scene::texture::wrap_coordinate;",
        body: "for (var mode = 0u; mode < 3u; mode += 1u) { out_f32(mode, wrap_coordinate(in_f32(0u), mode)); }",
        inputs: 1,
        outputs: 3,
        features: &[],
    };
    let numbers = coordinates();
    let answers = call(context, &function, &words(&numbers));
    for (mode, wrap) in WRAPS.into_iter().enumerate() {
        for (x, got) in numbers.iter().zip(answers.f64(mode)) {
            let expected = wrap_coordinate(*x, wrap);
            // A repeated image ends where it begins.
            let off = (got - expected).abs();
            let off = if wrap == Wrap::Repeat {
                off.min((1.0 - off).abs())
            } else {
                off
            };
            let bound = 2.0 * (1.0 + x.abs()) * f64::from(f32::EPSILON);
            assert!(
                off <= bound && (0.0..=1.0).contains(&got),
                "{wrap:?} {x}: {got}"
            );
        }
    }
}

#[test]
fn texels_beside_the_image_are_wrapped_like_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::scene::texture::wrap_texel;",
        body: "for (var mode = 0u; mode < 3u; mode += 1u) {
                   out_u32(mode, wrap_texel(bitcast<i32>(in_u32(0u)), bitcast<i32>(in_u32(1u)), mode));
               }",
        inputs: 2,
        outputs: 3,
        features: &[],
    };
    let counts = [1, 2, 3, 64, 16_384];
    let cases: Vec<(i64, u32)> = counts
        .into_iter()
        .flat_map(|n| [-1, 0, 1, i64::from(n) - 1, i64::from(n)].map(|texel| (texel, n)))
        .collect();
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(texel, n)| [*texel as i32 as u32, *n])
        .collect();
    let answers = call(context, &function, &inputs);
    for (mode, wrap) in WRAPS.into_iter().enumerate() {
        for ((texel, n), got) in cases.iter().zip(answers.u32(mode)) {
            assert_eq!(
                got,
                wrap_texel(*texel, *n, wrap),
                "{wrap:?}: {texel} of {n}"
            );
        }
    }
}

/// Where a footprint begins may differ by a texel where rounding decides; what it weighs is the
/// same: the point between the texels, as far as f32 tells points of `size` texels apart.
#[test]
fn footprints_are_the_twins() {
    let context = context();
    let function = Function {
        imports: "import package::scene::texture::{TextureUse, footprint};",
        body: "let t = TextureUse(in_vec3f(2u), in_vec3f(5u), vec2u(in_u32(8u), in_u32(9u)), vec2u(100u, 1000u), 0u, in_u32(10u));
               let f = footprint(t, in_vec2f(0u));
               out_u32(0u, f.left); out_u32(1u, f.right); out_u32(2u, f.top); out_u32(3u, f.bottom);
               out_vec2f(4u, f.blend);",
        inputs: 11,
        outputs: 6,
        features: &[],
    };
    let mut random = Random::new(63);
    let mut cases = Vec::new();
    for wrap_u in 0..3_u32 {
        for wrap_v in 0..3_u32 {
            for nearest in [false, true] {
                for size in [[1, 1], [2, 3], [64, 17], [2048, 4096]] {
                    for _ in 0..300 {
                        let mut number =
                            |range: f64| f64::from(random.between(-range, range) as f32);
                        let turn = DMat2::from_cols(
                            DVec2::new(number(2.0), number(2.0)),
                            DVec2::new(number(2.0), number(2.0)),
                        );
                        let offset = DVec2::new(number(1.0), number(1.0));
                        let uv = DVec2::new(number(1.5), number(1.5));
                        let used = TextureUse {
                            texture: TextureId(0),
                            transform: DAffine2::from_mat2_translation(turn, offset),
                            wrap: [WRAPS[wrap_u as usize], WRAPS[wrap_v as usize]],
                            interpolation: if nearest {
                                Interpolation::Nearest
                            } else {
                                Interpolation::Linear
                            },
                            second_uvs: false,
                        };
                        let modes = wrap_u | wrap_v << 2 | if nearest { NEAREST_BIT } else { 0 };
                        cases.push((used, size, uv, modes));
                    }
                }
            }
        }
    }
    let inputs: Vec<u32> = cases
        .iter()
        .flat_map(|(t, size, uv, modes)| {
            let (m, o) = (t.transform.matrix2, t.transform.translation);
            let mut item = words(&[
                uv.x, uv.y, m.x_axis.x, m.y_axis.x, o.x, m.x_axis.y, m.y_axis.y, o.y,
            ]);
            item.extend([size[0], size[1], *modes]);
            item
        })
        .collect();
    let answers = call(context, &function, &inputs);
    let corners = answers
        .u32(0)
        .zip(answers.u32(1))
        .zip(answers.u32(2).zip(answers.u32(3)));
    for ((case, corners), blend) in cases.iter().zip(corners).zip(answers.vec2(4)) {
        let (used, size, uv, _) = case;
        let expected = footprint(used, *size, *uv);
        let ((left, right), (top, bottom)) = corners;
        let got = [[left - 100, right - 100], [top - 1000, bottom - 1000]];
        let what = format!(
            "{}: {case:?}: {got:?} {blend}, {expected:?}",
            context.adapter.name
        );
        for axis in 0..2 {
            let [first, second] = got[axis];
            assert!(first < size[axis] && second < size[axis], "{what}");
            let wanted = [expected.columns, expected.rows][axis];
            let bound = 16.0 * f64::from(size[axis]) * f64::from(f32::EPSILON);
            let weight = expected.blend[axis];
            if used.interpolation == Interpolation::Nearest {
                // A point on the edge of a texel may fall to either side.
                let on_image = used.transform.transform_point2(*uv)[axis];
                let place = wrap_coordinate(on_image, used.wrap[axis]) * f64::from(size[axis]);
                let on_edge = (place - place.round()).abs() < bound;
                assert!(first == wanted[0] || on_edge, "{what}");
            } else if (bound..1.0 - bound).contains(&weight) {
                assert_eq!([first, second], wanted, "{what}");
                assert!((blend[axis] - weight).abs() <= bound, "{what}");
            }
        }
    }
}
