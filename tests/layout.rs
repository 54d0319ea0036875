//! Host structs and constants against the shaders': every member's name, offset and size, by naga's
//! reflection.

use direkt::low_level::gpu::layout::{
    self, BvhUniform, CameraUniform, Dispatch, EnvironmentUniform, FeatureSums, FilmUniform, Frame,
    LightInViewUniform, LightTreeUniform, LightsUniform, PatternsUniform, PixelState, RowTask,
    SampleRecord, ShadowUniform, SmallLightUniform, SurfaceRecord,
};
use direkt::low_level::gpu::shader::{KernelConstants, link_with};
use direkt_instruments::lab::layout::{LabBlock, LabRun};
use std::mem::offset_of;

/// A module that keeps all shared structs and constants alive.
fn reflected() -> naga::Module {
    let names: Vec<&str> = layout::shared_constants().iter().map(|c| c.name).collect();
    let mut source = String::from(
        "import package::types::{Frame, Dispatch, FeatureSums, PixelState, RowTask, SampleRecord, SurfaceRecord};\n",
    );
    for c in layout::shared_constants() {
        source += &format!("import package::{}::{};\n", c.module, c.name);
    }
    source += "@group(0) @binding(0) var<storage, read_write> frame: Frame;\n\
               @group(0) @binding(1) var<storage, read_write> work: Dispatch;\n\
               @group(0) @binding(2) var<storage, read_write> state: PixelState;\n\
               @group(0) @binding(3) var<storage, read_write> record: SampleRecord;\n\
               @group(0) @binding(4) var<storage, read_write> sums: FeatureSums;\n\
               @group(0) @binding(5) var<storage, read_write> surface: SurfaceRecord;\n\
               @group(0) @binding(6) var<storage, read_write> task: RowTask;\n\
               @compute @workgroup_size(1) fn main() {\n\
               frame.film.width = work.first_tile + state.samples + record.shadow + sums.samples + surface.primitive + task.row;\n";
    source += &format!("frame.film.height = {};\n}}\n", names.join(" + "));
    let wgsl = link_with(
        "test_layout",
        Some(&source),
        [],
        &KernelConstants::default(),
    )
    .unwrap();
    naga::front::wgsl::parse_str(&wgsl).unwrap()
}

struct Member {
    name: &'static str,
    offset: usize,
    size: usize,
}

macro_rules! members {
    ($ty:ident { $($field:ident),* $(,)? }) => {{
        let value = $ty::default();
        vec![$(Member {
            name: stringify!($field),
            offset: offset_of!($ty, $field),
            size: size_of_val(&value.$field),
        },)*]
    }};
}

fn check(module: &naga::Module, name: &str, host_size: usize, host: &[Member]) {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("the shaders have no struct {name}"));
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{name} is no struct");
    };
    assert_eq!(*span as usize, host_size, "size of {name}");
    assert_eq!(members.len(), host.len(), "number of members of {name}");
    for (shader, host) in members.iter().zip(host) {
        let shader_name = shader.name.as_deref().unwrap_or_default();
        let shader_size = module.types[shader.ty].inner.size(module.to_ctx()) as usize;
        assert_eq!(shader_name, host.name, "{name}");
        assert_eq!(
            shader.offset as usize, host.offset,
            "offset of {name}.{}",
            host.name
        );
        assert_eq!(shader_size, host.size, "size of {name}.{}", host.name);
    }
}

#[test]
fn structs_have_the_same_members() {
    let module = reflected();
    let camera = members!(CameraUniform {
        eye,
        near_plane,
        right,
        near_lens,
        up,
        inverse_focus_distance,
        forward,
        orthographic,
        lens_right,
        max_specular_depth,
        lens_up,
        padding
    });
    check(
        &module,
        "CameraUniform",
        size_of::<CameraUniform>(),
        &camera,
    );
    let film = members!(FilmUniform {
        width,
        height,
        tiles_per_row,
        filter_cell,
        filter_knots
    });
    check(&module, "FilmUniform", size_of::<FilmUniform>(), &film);
    let bvh = members!(BvhUniform {
        grid_origin,
        root,
        grid_scale,
        logarithmic_grid,
        small_box,
        padding,
    });
    check(&module, "BvhUniform", size_of::<BvhUniform>(), &bvh);
    let environment = members!(EnvironmentUniform {
        x,
        width,
        y,
        height,
        z,
        samples_per_ray,
        radiance,
        linear,
        grid,
        padding
    });
    check(
        &module,
        "EnvironmentUniform",
        size_of::<EnvironmentUniform>(),
        &environment,
    );
    let light_tree = members!(LightTreeUniform {
        grid_origin,
        nodes,
        grid_step,
        infinite_lights
    });
    check(
        &module,
        "LightTreeUniform",
        size_of::<LightTreeUniform>(),
        &light_tree,
    );
    let lights = members!(LightsUniform {
        count,
        first_sun,
        suns,
        first_emission,
        boxes
    });
    check(
        &module,
        "LightsUniform",
        size_of::<LightsUniform>(),
        &lights,
    );
    let patterns = members!(PatternsUniform { pixel, light });
    check(
        &module,
        "PatternsUniform",
        size_of::<PatternsUniform>(),
        &patterns,
    );
    let shadow = members!(ShadowUniform {
        rays,
        columns,
        steps
    });
    check(
        &module,
        "ShadowUniform",
        size_of::<ShadowUniform>(),
        &shadow,
    );
    let frame = members!(Frame {
        camera,
        film,
        bvh,
        environment,
        light_tree,
        lights,
        patterns,
        shadow,
        seed,
        far,
        lights_in_view_count,
        small_lights_count,
        lights_in_view,
        small_lights
    });
    let small_light = members!(SmallLightUniform {
        place,
        radius,
        area,
        kind,
        strength,
        is_in_view
    });
    check(
        &module,
        "SmallLightUniform",
        size_of::<SmallLightUniform>(),
        &small_light,
    );
    let light_in_view = members!(LightInViewUniform {
        bounds,
        light,
        points,
        per_sample,
        padding
    });
    check(
        &module,
        "LightInViewUniform",
        size_of::<LightInViewUniform>(),
        &light_in_view,
    );
    let dispatch = members!(Dispatch {
        block_start,
        first_tile,
        first_task,
        target_position,
        padding,
    });
    let task = members!(RowTask {
        block_start,
        row,
        target_position,
    });
    let state = members!(PixelState {
        mean,
        samples,
        m2,
        dropped,
        shadow_rays,
        bsdf_rays,
        first_bad,
        expected_hits,
        second_mean,
        second_samples,
        second_m2,
        expected_squares,
    });
    let record = members!(SampleRecord {
        radiance,
        shadow,
        by_light,
        camera_primitive,
        by_bsdf,
        bsdf_primitive,
    });
    let sums = members!(FeatureSums {
        albedo,
        samples,
        normal,
        padding,
    });
    let surface = members!(SurfaceRecord {
        position,
        primitive,
        normal,
        padding,
    });
    check(&module, "FeatureSums", size_of::<FeatureSums>(), &sums);
    check(
        &module,
        "SurfaceRecord",
        size_of::<SurfaceRecord>(),
        &surface,
    );
    check(&module, "SampleRecord", size_of::<SampleRecord>(), &record);
    check(&module, "Frame", size_of::<Frame>(), &frame);
    check(&module, "Dispatch", size_of::<Dispatch>(), &dispatch);
    check(&module, "RowTask", size_of::<RowTask>(), &task);
    check(&module, "PixelState", size_of::<PixelState>(), &state);
}

#[test]
fn the_labs_structs_have_the_same_members() {
    let source = "import package::lab::types::{LabRun, LabBlock};
        @group(0) @binding(0) var<uniform> work: LabRun;
        @group(0) @binding(1) var<storage, read_write> block: LabBlock;
        @compute @workgroup_size(1) fn main() { block.samples = work.samples; }";
    let wgsl = link_with("test_layout", Some(source), [], &KernelConstants::default()).unwrap();
    let module = naga::front::wgsl::parse_str(&wgsl).unwrap();
    let run = members!(LabRun {
        variant,
        items,
        first_item,
        samples,
        seed,
        stream,
        size,
        dimensions,
        constants,
    });
    let block = members!(LabBlock {
        mean,
        m2,
        samples,
        tries,
    });
    check(&module, "LabRun", size_of::<LabRun>(), &run);
    check(&module, "LabBlock", size_of::<LabBlock>(), &block);
}

#[test]
fn constants_have_the_same_values() {
    let module = reflected();
    for expected in layout::shared_constants() {
        let (_, constant) = module
            .constants
            .iter()
            .find(|(_, c)| c.name.as_deref() == Some(expected.name))
            .unwrap_or_else(|| panic!("the shaders have no constant {}", expected.name));
        let value = &module.global_expressions[constant.init];
        let naga::Expression::Literal(naga::Literal::U32(value)) = value else {
            panic!("{} is no u32 literal: {value:?}", expected.name);
        };
        assert_eq!(*value, expected.value, "{}", expected.name);
    }
}

#[test]
fn a_workgroup_is_a_tile() {
    let wgsl =
        direkt::low_level::gpu::shader::link("kernel::direct", [], &KernelConstants::default())
            .unwrap();
    let module = naga::front::wgsl::parse_str(&wgsl).unwrap();
    let entry = &module.entry_points[0];
    assert_eq!(entry.workgroup_size, [layout::TILE_PIXELS, 1, 1]);
    let mut seen: Vec<_> = (0..layout::TILE_PIXELS).map(layout::lane_pixel).collect();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), layout::TILE_PIXELS as usize);
    assert!(
        seen.iter()
            .all(|&(x, y)| x < layout::TILE && y < layout::TILE)
    );
}
