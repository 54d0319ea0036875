//! `shaders/scene/bindings.wesl`: what is bound is what the host has. Pixels and the mark of
//! unfinished ones are written by renders; see `tests/render/`.

use super::prepared;
use crate::support::context;
use crate::support::every_kind::{environment_map, every_kind};
use crate::support::shader::{Function, call_in};
use direkt::low_level::gpu::layout::MATERIAL_WORDS;
use direkt::low_level::gpu::{GpuScene, SceneBuffers, frame_of};
use direkt::scene::EnvironmentRadiance;
use direkt::scene::environment::Interpolation;

#[test]
fn the_frame_is_the_hosts() {
    let context = context();
    let prepared = prepared(every_kind(environment_map(Interpolation::Linear)));
    let function = Function {
        imports: "import package::scene::bindings::frame;",
        body: "out_vec3f(0u, frame.camera.eye);
               out_f32(3u, frame.camera.near_plane);
               out_vec3f(4u, frame.camera.right);
               out_f32(7u, frame.camera.near_lens);
               out_vec3f(8u, frame.camera.up);
               out_f32(11u, frame.camera.inverse_focus_distance);
               out_vec3f(12u, frame.camera.forward);
               out_u32(15u, frame.camera.orthographic);
               out_vec3f(16u, frame.camera.lens_right);
               out_u32(19u, frame.camera.max_specular_depth);
               out_vec3f(20u, frame.camera.lens_up);
               out_u32(23u, frame.film.width);
               out_u32(24u, frame.film.height);
               out_u32(25u, frame.film.tiles_per_row);
               out_f32(26u, frame.film.filter_cell);
               out_vec3f(27u, frame.film.filter_knots[1].yzw);
               out_vec3f(30u, frame.bvh.grid_origin);
               out_u32(33u, frame.bvh.root);
               out_vec3f(34u, frame.bvh.grid_scale);
               out_u32(37u, frame.bvh.logarithmic_grid);
               out_vec3f(38u, frame.environment.x);
               out_u32(41u, frame.environment.width);
               out_vec3f(42u, frame.environment.y);
               out_u32(45u, frame.environment.height);
               out_vec3f(46u, frame.environment.z);
               out_f32(49u, frame.environment.samples_per_ray);
               out_vec3f(50u, frame.environment.radiance);
               out_u32(53u, frame.environment.linear);
               out_u32(54u, frame.environment.grid.x); out_u32(55u, frame.environment.grid.y);
               out_vec3f(56u, frame.light_tree.grid_origin);
               out_u32(59u, frame.light_tree.nodes);
               out_vec3f(60u, frame.light_tree.grid_step);
               out_u32(63u, frame.light_tree.infinite_lights);
               out_u32(64u, frame.lights.count);
               out_u32(65u, frame.lights.first_sun);
               out_u32(66u, frame.lights.suns);
               out_u32(67u, frame.lights.first_emission);
               out_u32(68u, frame.lights.boxes[0].x);
               out_u32(69u, frame.lights.boxes[0].y);
               out_u32(70u, frame.lights.boxes[0].z);
               out_u32(71u, frame.patterns.pixel.x); out_u32(72u, frame.patterns.pixel.y);
               out_u32(73u, frame.patterns.light.x); out_u32(74u, frame.patterns.light.y);
               out_u32(75u, frame.shadow.rays);
               out_u32(76u, frame.shadow.columns);
               out_u32(77u, frame.shadow.steps.x); out_u32(78u, frame.shadow.steps.y);
               out_u32(79u, frame.seed);
               out_f32(80u, frame.far);",
        outputs: 81,
        ..Function::default()
    };
    let answers = call_in(context, &prepared, &function, &[], 1);
    let frame = frame_of(&prepared, prepared.film, prepared.settings.seed);
    let floats = |x: &[f32]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let expected = [
        floats(&frame.camera.eye),
        floats(&[frame.camera.near_plane]),
        floats(&frame.camera.right),
        floats(&[frame.camera.near_lens]),
        floats(&frame.camera.up),
        floats(&[frame.camera.inverse_focus_distance]),
        floats(&frame.camera.forward),
        vec![frame.camera.orthographic],
        floats(&frame.camera.lens_right),
        vec![frame.camera.max_specular_depth],
        floats(&frame.camera.lens_up),
        vec![frame.film.width],
        vec![frame.film.height],
        vec![frame.film.tiles_per_row],
        floats(&[frame.film.filter_cell]),
        floats(&frame.film.filter_knots[1][1..]),
        floats(&frame.bvh.grid_origin),
        vec![frame.bvh.root],
        floats(&frame.bvh.grid_scale),
        vec![frame.bvh.logarithmic_grid],
        floats(&frame.environment.x),
        vec![frame.environment.width],
        floats(&frame.environment.y),
        vec![frame.environment.height],
        floats(&frame.environment.z),
        floats(&[frame.environment.samples_per_ray]),
        floats(&frame.environment.radiance),
        vec![frame.environment.linear],
        frame.environment.grid.to_vec(),
        floats(&frame.light_tree.grid_origin),
        vec![frame.light_tree.nodes],
        floats(&frame.light_tree.grid_step),
        vec![frame.light_tree.infinite_lights],
        vec![frame.lights.count],
        vec![frame.lights.first_sun],
        vec![frame.lights.suns],
        vec![frame.lights.first_emission],
        frame.lights.boxes[0][..3].to_vec(),
        frame.patterns.pixel.to_vec(),
        frame.patterns.light.to_vec(),
        vec![frame.shadow.rays],
        vec![frame.shadow.columns],
        frame.shadow.steps.to_vec(),
        vec![frame.seed],
        floats(&[frame.far]),
    ];
    let found: Vec<u32> = (0..function.outputs)
        .map(|i| answers.u32(i).next().unwrap())
        .collect();
    assert_eq!(found, expected.concat());
}

#[test]
fn buffers_have_the_hosts_lengths_and_words() {
    let context = context();
    let prepared = prepared(every_kind(environment_map(Interpolation::Nearest)));
    let lengths = Function {
        imports: "import package::scene::bindings::{
                      environment_alias, environment_texels, light_choice, lights, materials, nodes, primitives};",
        body: "out_u32(0u, arrayLength(&nodes)); out_u32(1u, arrayLength(&primitives));
               out_u32(2u, arrayLength(&materials)); out_u32(3u, arrayLength(&lights));
               out_u32(4u, arrayLength(&light_choice)); out_u32(5u, arrayLength(&environment_alias));
               out_u32(6u, textureDimensions(environment_texels).x);
               out_u32(7u, textureDimensions(environment_texels).y);",
        outputs: 8,
        ..Function::default()
    };
    let answers = call_in(context, &prepared, &lengths, &[], 1);
    let found: Vec<u32> = (0..8).map(|i| answers.u32(i).next().unwrap()).collect();
    let node_words: &[[u32; 4]] = bytemuck::cast_slice(&prepared.data.bvh.nodes);
    let selection = prepared.emitters.selection.as_ref().unwrap();
    let selection = selection.table().unwrap();
    let expected = [
        node_words.len(),
        3 * prepared.data.primitives.len(),
        MATERIAL_WORDS as usize * prepared.data.scene.materials.len(),
        4 * prepared.emitters.lights.len(),
        selection.entries.len(),
        31 * 17,
        31,
        17,
    ];
    assert_eq!(found, expected.map(|n| n as u32));

    let word = |array: &str, expected: &[[u32; 4]]| {
        let function = Function {
            imports: &format!("import package::scene::bindings::{array};"),
            body: &format!(
                "let word = {array}[item];
                 out_u32(0u, word.x); out_u32(1u, word.y); out_u32(2u, word.z); out_u32(3u, word.w);"
            ),
            outputs: 4,
            ..Function::default()
        };
        let answers = call_in(context, &prepared, &function, &[], expected.len());
        for (i, expected) in expected.iter().enumerate() {
            let found = [0, 1, 2, 3].map(|word| answers.u32(word).nth(i).unwrap());
            assert_eq!(found, *expected, "{array}[{i}]");
        }
    };
    let alias = |table: &direkt::scene::alias_table::AliasTable| -> Vec<[u32; 4]> {
        let bits = |i: u32| (table.probability[i as usize] as f32).to_bits();
        let entries = (0..).zip(&table.entries);
        entries
            .map(|(i, e)| [e.threshold, e.alias, bits(i), bits(e.alias)])
            .collect()
    };
    word("nodes", node_words);
    word("light_choice", &alias(selection));
    word(
        "environment_alias",
        &alias(&prepared.emitters.environment.as_ref().unwrap().table),
    );
}

#[test]
fn texels_are_the_maps() {
    let context = context();
    let prepared = prepared(every_kind(environment_map(Interpolation::Nearest)));
    let function = Function {
        imports: "import package::light::environment::environment_texel;",
        body: "out_vec3f(0u, environment_texel(item % 31u, item / 31u));",
        outputs: 3,
        ..Function::default()
    };
    let answers = call_in(context, &prepared, &function, &[], 31 * 17);
    let EnvironmentRadiance::Map(map) = &prepared.data.scene.environment.as_ref().unwrap().radiance
    else {
        unreachable!("the environment is a map");
    };
    for (i, (found, texel)) in answers.vec3(0).zip(&map.texels).enumerate() {
        assert_eq!(found.as_vec3().to_array(), *texel, "texel {i}");
    }
}

/// What `explain` tells of memory: naming every field here makes a new one a mistake until it is
/// counted.
#[test]
fn buffers_are_as_large_as_is_told() {
    let context = context();
    for environment in [
        environment_map(Interpolation::Linear),
        environment_map(Interpolation::Nearest),
    ] {
        let prepared = prepared(every_kind(environment));
        let SceneBuffers {
            scene,
            materials,
            lights,
            light_choice,
            environment_alias,
            emission_cells,
        } = SceneBuffers::new(context, &prepared).unwrap();
        let GpuScene {
            nodes,
            primitives,
            attributes,
            textures,
            environment,
        } = &*scene;
        let size = environment.texture().size();
        for array in [&textures.colors, &textures.data] {
            assert_eq!(array.view.texture().size().width, 1, "no texture");
        }
        let found = [
            ("scene.nodes", nodes.bytes()),
            ("scene.primitives", primitives.bytes()),
            ("scene.materials", materials.bytes()),
            ("scene.lights", lights.bytes()),
            ("scene.light_choice", light_choice.bytes()),
            ("scene.attributes", attributes.bytes()),
            ("scene.color_textures", 4),
            ("scene.data_textures", 4),
            ("scene.emission_cells", emission_cells.bytes()),
            ("scene.environment_alias", environment_alias.bytes()),
            (
                "scene.environment",
                u64::from(size.width * size.height) * 16,
            ),
        ];
        assert_eq!(SceneBuffers::sizes(&prepared), found);
    }
}
