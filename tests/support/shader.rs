//! The shader test harness: names a WGSL function, gives inputs, gets outputs.
//!
//! A one-entry kernel is linked around the function. Its output buffer is poisoned first, and every
//! slot has to have been written. The function may use a scene's bindings.

use super::floor_pixel;
use direkt::low_level::gpu::kernel::{KernelDescriptor, READ_WRITE};
use direkt::low_level::gpu::layout::Dispatch;
use direkt::low_level::gpu::program::{POISON, SceneProgram};
use direkt::low_level::gpu::{Context, GpuBuffer};
use direkt::low_level::prepare::Prepared;

/// Invocations of one dispatch at most.
const MAX_ITEMS: usize = 65_535 * 64;

const READ: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// A WGSL function under test.
///
/// `body` runs once per item. It reads the item's input words with `in_u32(i)`, `in_f32(i)`,
/// `in_vec2f(i)`, `in_vec3f(i)` and writes its output words with `out_u32(i, x)`, `out_bool(i, x)`,
/// `out_f32(i, x)`, `out_vec2f(i, x)`, `out_vec3f(i, x)`, where `i` is the number of the first
/// word; `item` is the item's number.
#[derive(Debug, Clone, Copy, Default)]
pub struct Function<'a> {
    /// `import package::…;` lines.
    pub imports: &'a str,
    /// Statements.
    pub body: &'a str,
    /// Input words per item.
    pub inputs: usize,
    /// Output words per item.
    pub outputs: usize,
    /// WESL features beside those that the scene calls for.
    pub features: &'a [&'static str],
}

/// The answers of a function: `outputs` words per item.
#[derive(Debug, Clone)]
pub struct Answers {
    words: Vec<u32>,
    outputs: usize,
}

impl Answers {
    /// Word `i` of every item, as u32.
    pub fn u32(&self, i: usize) -> impl Iterator<Item = u32> {
        self.words.chunks_exact(self.outputs).map(move |w| w[i])
    }

    /// Word `i` of every item, as f32 widened to f64.
    pub fn f64(&self, i: usize) -> impl Iterator<Item = f64> {
        self.u32(i).map(|w| f64::from(f32::from_bits(w)))
    }

    /// Words `i` and `i + 1` of every item.
    pub fn vec2(&self, i: usize) -> impl Iterator<Item = glam::DVec2> {
        self.f64(i).zip(self.f64(i + 1)).map(glam::DVec2::from)
    }

    /// Words `i` to `i + 2` of every item.
    pub fn vec3(&self, i: usize) -> impl Iterator<Item = glam::DVec3> {
        let xy = self.vec2(i);
        xy.zip(self.f64(i + 2)).map(|(xy, z)| xy.extend(z))
    }
}

/// Bits of f64s as f32s, for input words.
pub fn words(values: &[f64]) -> Vec<u32> {
    values.iter().map(|&x| (x as f32).to_bits()).collect()
}

/// Runs `function` on `items`, `function.inputs` words each, without a scene.
pub fn call(context: &Context, function: &Function<'_>, items: &[u32]) -> Answers {
    assert!(function.inputs > 0, "without inputs, say how many: `draw`");
    call_in(
        context,
        &empty(),
        function,
        items,
        items.len() / function.inputs,
    )
}

/// Runs `function` `count` times, without inputs and without a scene; `item` tells the runs apart.
pub fn draw(context: &Context, function: &Function<'_>, count: usize) -> Answers {
    call_in(context, &empty(), function, &[], count)
}

fn empty() -> Prepared {
    Prepared::of(floor_pixel())
}

/// Runs `function` on `count` items with the scene bound. The frame is that of the scene's film and
/// seed.
///
/// # Panics
/// The kernel does not link, or a slot was not written.
pub fn call_in(
    context: &Context,
    prepared: &Prepared,
    function: &Function<'_>,
    items: &[u32],
    count: usize,
) -> Answers {
    let adapter = &context.adapter.name;
    assert!(count > 0 && count <= MAX_ITEMS, "{count} items");
    assert_eq!(items.len(), count * function.inputs, "input words");
    let source = source(function, count);
    let descriptor = KernelDescriptor {
        name: "test_function",
        module: "test_function",
        source: Some(&source),
        features: function.features,
        extra_bindings: &[READ, READ_WRITE],
    };
    let (film, seed) = (prepared.film, prepared.settings.seed);
    let program = SceneProgram::new(context, prepared, film, seed, &descriptor)
        .unwrap_or_else(|e| panic!("{adapter}: {e}\n{source}"));
    let device = &context.device;
    let inputs = GpuBuffer::storage(device, "test.inputs", items);
    let storage =
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
    let length = count * function.outputs;
    let outputs = GpuBuffer::<u32>::zeroed(device, "test.outputs", length, storage);
    let staging = GpuBuffer::<u32>::zeroed(device, "test.staging", length, read);
    let extra = program
        .kernel()
        .bind_extra(device, vec![inputs.binding(), outputs.binding()]);
    let groups = count.div_ceil(64) as u32;
    let words = program
        .run(
            &Dispatch::default(),
            groups,
            &extra,
            (&outputs, &staging),
            <[u32]>::to_vec,
        )
        .unwrap_or_else(|e| panic!("{adapter}: {e}"));
    let unwritten = words.iter().position(|&w| w == POISON);
    if let Some(i) = unwritten {
        let (item, word) = (i / function.outputs, i % function.outputs);
        panic!("{adapter}: item {item} did not write word {word}\n{source}");
    }
    Answers {
        words,
        outputs: function.outputs,
    }
}

fn source(function: &Function<'_>, count: usize) -> String {
    let Function {
        imports,
        body,
        inputs,
        outputs,
        ..
    } = function;
    format!(
        "{imports}

@group(2) @binding(0) var<storage, read> input_words: array<u32>;
@group(2) @binding(1) var<storage, read_write> output_words: array<u32>;
var<private> item: u32;

fn in_u32(i: u32) -> u32 {{ return input_words[item * {inputs}u + i]; }}
fn in_f32(i: u32) -> f32 {{ return bitcast<f32>(in_u32(i)); }}
fn in_vec2f(i: u32) -> vec2f {{ return vec2f(in_f32(i), in_f32(i + 1u)); }}
fn in_vec3f(i: u32) -> vec3f {{ return vec3f(in_f32(i), in_f32(i + 1u), in_f32(i + 2u)); }}
fn out_u32(i: u32, x: u32) {{ output_words[item * {outputs}u + i] = x; }}
fn out_bool(i: u32, x: bool) {{ out_u32(i, select(0u, 1u, x)); }}
fn out_f32(i: u32, x: f32) {{ out_u32(i, bitcast<u32>(x)); }}
fn out_vec2f(i: u32, x: vec2f) {{ out_f32(i, x.x); out_f32(i + 1u, x.y); }}
fn out_vec3f(i: u32, x: vec3f) {{ out_vec2f(i, x.xy); out_f32(i + 2u, x.z); }}

@compute @workgroup_size(64)
fn test_function(@builtin(global_invocation_id) id: vec3u) {{
    item = id.x;
    if item >= {count}u {{
        return;
    }}
    {body}
}}
"
    )
}
