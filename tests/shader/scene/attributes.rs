//! `shaders/scene/attributes.wesl`: vertex normals, texture coordinates and vertex colours.

use crate::support::context;
use crate::support::random::Random;
use crate::support::rounding::U;
use crate::support::shader::{Answers, Function, call, call_in, words};
use direkt::low_level::reference::scene::attributes::{
    interpolate_color, interpolate_normal, map_normal, seen_normal, terminator_offset, uvs_of,
};
use direkt::low_level::reference::scene::fetch::World;
use glam::{DVec2, DVec3, DVec4};

/// A triangle with vertex normals and texture coordinates, a point of it, a value of a normal map
/// and a view.
struct Case {
    normals: [DVec3; 3],
    st: DVec2,
    u: DVec3,
    v: DVec3,
    uvs: [DVec2; 3],
    mapped: DVec3,
    wo: DVec3,
    colors: [DVec4; 3],
}

fn cases() -> Vec<Case> {
    let mut random = Random::new(64);
    let mut cases = Vec::new();
    while cases.len() < 20_000 {
        let (u, v) = random.edges();
        let own = u.cross(v).normalize();
        let lean = |random: &mut Random| (own + 0.8 * random.direction()).normalize();
        let normals = [lean(&mut random), lean(&mut random), lean(&mut random)];
        let mut point = || DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let uvs = [point(), point(), point()];
        let area = (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]);
        if area.abs() < 0.05 {
            continue;
        }
        let s = random.between(0.0, 1.0);
        let t = random.between(0.0, 1.0 - s);
        let mapped = random.in_cube() * DVec3::new(1.0, 1.0, 0.5) + 0.5 * DVec3::Z;
        let wo = random.direction();
        let mut color = || {
            let [x, y, z, w] = [0; 4].map(|_| random.between(0.0, 1.0));
            DVec4::new(x, y, z, w).as_vec4().as_dvec4()
        };
        let colors = [color(), color(), color()];
        let rounded = |v: DVec3| v.as_vec3().as_dvec3();
        cases.push(Case {
            normals: normals.map(rounded),
            st: DVec2::new(s, t).as_vec2().as_dvec2(),
            u: rounded(u),
            v: rounded(v),
            uvs: uvs.map(|p| p.as_vec2().as_dvec2()),
            mapped: rounded(mapped),
            wo: if wo.dot(own) < 0.0 {
                rounded(-wo)
            } else {
                rounded(wo)
            },
            colors,
        });
    }
    cases
}

fn answers(cases: &[Case]) -> Answers {
    let context = context();
    let function = Function {
        imports: "import package::scene::attributes::{
                      VertexColors, VertexNormals, VertexUvs, interpolate_color, interpolate_normal, map_normal,
                      seen_normal, terminator_offset
                  };",
        body: "let n = VertexNormals(in_vec3f(0u), in_vec3f(3u), in_vec3f(6u));
               let st = in_vec2f(9u);
               let u = in_vec3f(11u);
               let v = in_vec3f(14u);
               let uvs = VertexUvs(in_vec2f(17u), in_vec2f(19u), in_vec2f(21u));
               let own = normalize(cross(u, v));
               out_vec3f(0u, interpolate_normal(n, st, own));
               out_vec3f(3u, terminator_offset(n, st, u, v, 1.0));
               out_vec3f(6u, terminator_offset(n, st, u, v, -1.0));
               out_vec3f(9u, map_normal(in_vec3f(23u), uvs, u, v, n.a));
               out_vec3f(12u, seen_normal(n.a, in_vec3f(26u)));
               let colors = VertexColors(
                   vec4f(in_vec3f(29u), in_f32(32u)), vec4f(in_vec3f(33u), in_f32(36u)), vec4f(in_vec3f(37u), in_f32(40u)));
               let color = interpolate_color(colors, st);
               out_vec3f(15u, color.xyz);
               out_f32(18u, color.w);",
        inputs: 41,
        outputs: 19,
        features: &["SMOOTH_NORMALS", "NORMAL_MAP"],
    };
    let numbers: Vec<f64> = cases
        .iter()
        .flat_map(|c| {
            let mut item: Vec<f64> = c.normals.iter().flat_map(|n| n.to_array()).collect();
            item.extend(c.st.to_array());
            item.extend([c.u.to_array(), c.v.to_array()].concat());
            item.extend(c.uvs.iter().flat_map(|p| p.to_array()));
            item.extend([c.mapped.to_array(), c.wo.to_array()].concat());
            item.extend(c.colors.iter().flat_map(|p| p.to_array()));
            item
        })
        .collect();
    call(context, &function, &words(&numbers))
}

/// Interpolation and offsets are sums of a dozen products of numbers up to the edges' lengths;
/// dividing by a short sum of normals amplifies.
#[test]
fn normals_and_offsets_are_the_twins() {
    let cases = cases();
    let answers = answers(&cases);
    for (i, c) in cases.iter().enumerate() {
        let got = |word: usize| answers.vec3(word).nth(i).expect("as many as cases");
        let own = c.u.cross(c.v).normalize();
        let [a, b, d] = c.normals;
        let sum = (1.0 - c.st.x - c.st.y) * a + c.st.x * b + c.st.y * d;
        let normal = got(0);
        let expected = interpolate_normal(&c.normals, c.st, own);
        let off = normal.distance(expected);
        assert!(off < 16.0 * U / sum.length().min(1.0), "{off:e}");
        let size = c.u.length() + c.v.length();
        for (word, side) in [(3, 1.0), (6, -1.0)] {
            let expected = terminator_offset(&c.normals, c.st, c.u, c.v, side);
            let off = got(word).distance(expected);
            assert!(off < 32.0 * U * size, "{off:e} of {size}");
        }
    }
}

/// A sum of five numbers up to 1.
#[test]
fn colours_are_the_twins() {
    let cases = cases();
    let answers = answers(&cases);
    let found = answers.vec3(15).zip(answers.f64(18));
    for (c, (rgb, alpha)) in cases.iter().zip(found) {
        let expected = interpolate_color(&c.colors, c.st);
        let off = (rgb.extend(alpha) - expected).abs().max_element();
        assert!(off < 8.0 * U, "{off:e}");
    }
}

/// The tangent is a difference of products over texture coordinates that span 0.05 or more; what of
/// it lies along the normal is taken off again, and what the normal map says added up.
#[test]
fn mapped_normals_are_the_twins() {
    let cases = cases();
    let answers = answers(&cases);
    for (i, c) in cases.iter().enumerate() {
        let (du, dv) = (c.uvs[1] - c.uvs[0], c.uvs[2] - c.uvs[0]);
        let terms = c.u.length() * dv.y.abs() + c.v.length() * du.y.abs();
        let along_u = c.u * dv.y - c.v * du.y;
        let normal = c.normals[0];
        let tangent = (along_u - normal * normal.dot(along_u)).length();
        let expected = map_normal(c.mapped, &c.uvs, c.u, c.v, normal);
        let got = answers.vec3(9).nth(i).expect("as many as cases");
        let bound = (16.0 * terms / tangent + 16.0) * U / c.mapped.length().min(1.0);
        let off = got.distance(expected);
        assert!(off < bound || bound > 0.1, "{off:e}, bound {bound:e}");
    }
}

/// Whatever a normal is, its surface is seen: the cosine to the viewer is above zero.
#[test]
fn seen_normals_face_the_viewer() {
    let cases = cases();
    let answers = answers(&cases);
    for (c, got) in cases.iter().zip(answers.vec3(12)) {
        let before = c.normals[0].dot(c.wo);
        // Turned right round where it is opposite, a normal is all rounding.
        if before > -0.99 {
            let expected = seen_normal(c.normals[0], c.wo);
            assert!(got.distance(expected) < 64.0 * U, "{got} {expected}");
            assert!(got.dot(c.wo) > 0.0, "{got} from {}", c.wo);
        }
        if before > 0.011 {
            assert!(got.distance(c.normals[0]) < 8.0 * U, "{got}");
        }
    }
}

/// Each texture of a material with two sets of texture coordinates is read with its own, behind
/// vertex colours.
#[test]
fn textures_are_read_with_the_coordinates_of_their_set() {
    let prepared = super::prepared(crate::render::second_uvs::floor([false, true]));
    let world = World::new(&prepared);
    let material = &prepared.data.scene.materials[0];
    let function = Function {
        imports: "import package::scene::attributes::{fetch_uvs, uvs_of};
                  import package::scene::fetch::{fetch_primitive, textured_word};
                  import package::scene::bindings::materials;
                  import package::scene::textured::fetch_textures;",
        body: "let p = fetch_primitive(item);
               let word = textured_word(p.material);
               let first = fetch_uvs(p);
               let color = uvs_of(p, first, fetch_textures(word).color);
               let alpha = uvs_of(p, first, bitcast<u32>(materials[word + 3u].w));
               out_vec2f(0u, color.a); out_vec2f(2u, color.b); out_vec2f(4u, color.c);
               out_vec2f(6u, alpha.a); out_vec2f(8u, alpha.b); out_vec2f(10u, alpha.c);",
        outputs: 12,
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], world.primitives.len());
    let textures = [material.textures.color, material.opacity.texture];
    for (first_word, texture) in [0, 6].into_iter().zip(textures) {
        let texture = texture.expect("both are there");
        for (i, p) in world.primitives.iter().enumerate() {
            let expected = uvs_of(&world, p, &texture);
            assert_eq!(expected[0].x > 0.5, texture.second_uvs);
            for (corner, expected) in expected.into_iter().enumerate() {
                let got = answers.vec2(first_word + 2 * corner).nth(i);
                assert_eq!(got, Some(expected), "primitive {i}");
            }
        }
    }
}
