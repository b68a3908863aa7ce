//! Convolutions as straight-line code for CPU drivers such as lavapipe.
//!
//! llvmpipe runs eight invocations in the lanes of one vector. A weight that every lane needs
//! is cheapest when each lane loads a different one and `subgroupBroadcast` with a constant
//! lane hands them round; accumulators are cheapest as separate variables. WGSL has neither
//! unrolling nor templates, so this module writes the text. The plain kernels remain the
//! definition, and the tests hold every generated variant against the same reference.
//!
//! Each invocation makes four pixels of a row and `4 · out_quads` output channels.
//! Reads outside of a tensor rely on the driver to give 0, which lavapipe does and the border
//! cases of the tests confirm; on GPUs the tiled kernels run instead.

use std::fmt::Write as _;

use super::packing::{Taps, weight_texture};
use crate::kernel::{Binding, Context, KernelSpec};

/// What the generated kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// [`super::conv3x3`].
    Conv3x3,
    /// [`super::conv_transpose`].
    ConvTranspose,
    /// [`super::conv1x1`].
    Conv1x1,
}

/// Pixels of a row that one invocation makes.
pub const PIXELS: u32 = 4;
/// Invocations that share a set of weights: the subgroup of llvmpipe with 256-bit vectors, its
/// default on today's CPUs. Smaller ones must run another variant.
pub const LANES: u32 = 8;

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 3] = [Self::Conv3x3, Self::ConvTranspose, Self::Conv1x1];

    fn name(self) -> &'static str {
        match self {
            Self::Conv3x3 => "conv3x3",
            Self::ConvTranspose => "conv_transpose",
            Self::Conv1x1 => "conv1x1",
        }
    }

    /// Side of the kernel window that one step walks along a row.
    fn side(self) -> usize {
        if self == Self::Conv3x3 { 3 } else { 1 }
    }

    /// How often the input is read for different output pixels.
    fn corners(self) -> usize {
        if self == Self::ConvTranspose { 4 } else { 1 }
    }
}

/// Output quads per invocation for a layer: 16 channels fill the registers, fewer waste none.
#[must_use]
pub fn quads_per_invocation(outputs: usize) -> usize {
    outputs.div_ceil(4).min(4)
}

/// The generated kernel.
#[must_use]
pub fn spec(shape: Shape, out_quads: usize) -> KernelSpec {
    let overrides: &[&str] =
        if shape == Shape::Conv3x3 { &["largest", "relu"] } else { &["largest"] };
    KernelSpec {
        name: format!("{}_simd{}", shape.name(), out_quads * 4).into(),
        source: source(shape, out_quads).into(),
        entry: "main",
        bindings: &[Binding::TensorIn, Binding::TensorOut, Binding::WeightTexture, Binding::Buffer],
        overrides,
        workgroup: [LANES, 1, 1],
    }
}

/// Blocks of `4 · out_quads` output channels, per corner.
#[must_use]
pub fn blocks(shape: Shape, outputs: usize) -> usize {
    shape.corners() * outputs.div_ceil(4 * quads_per_invocation(outputs))
}

/// The weights as the generated kernel reads them: layer = block, row = step (kernel row ×
/// input quad), texel = (kernel column × input channel × output quad), padded to whole lanes.
#[must_use]
pub fn pack(context: &Context, shape: Shape, taps: &Taps<'_>) -> wgpu::TextureView {
    let quads = quads_per_invocation(taps.outputs);
    let (side, in_quads) = (shape.side(), taps.in_quads());
    let width = (side * 4 * quads).next_multiple_of(LANES as usize);
    let (steps, blocks) = (side * in_quads, blocks(shape, taps.outputs));
    let mut texels = vec![0.0; blocks * steps * width * 4];
    for (i, texel) in texels.chunks_exact_mut(4).enumerate() {
        let (x, step, block) = (i % width, i / width % steps, i / width / steps);
        let (column, channel, quad) = (x / quads / 4, x / quads % 4, x % quads);
        if column >= side {
            continue;
        }
        let (corner, part) = (block % shape.corners(), block / shape.corners());
        let tap = if side == 3 { step / in_quads * 3 + column } else { corner };
        let output = (part * quads + quad) * 4;
        for (k, value) in texel.iter_mut().enumerate() {
            *value = taps.at(output + k, step % in_quads * 4 + channel, tap);
        }
    }
    weight_texture(context, [width as u32, steps as u32, blocks as u32], &texels)
}

fn source(shape: Shape, quads: usize) -> String {
    let side = shape.side();
    let relu = if side == 3 { "override relu: bool;" } else { "" };
    let floor = if side == 3 { "select(-largest, 0.0, relu)" } else { "-largest" };
    format!(
        "// {name}: {channels} output channels of {PIXELS} pixels per invocation.\n\
alias TensorIn = texture_storage_2d_array<rgba32float, read>;\n\
alias TensorOut = texture_storage_2d_array<rgba32float, write>;\n\
@group(0) @binding(0) var input: TensorIn;\n\
@group(0) @binding(1) var output: TensorOut;\n\
@group(0) @binding(2) var weights: texture_storage_2d_array<rgba32float, read>;\n\
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;\n\
override largest: f32;\n\
{relu}\n\
@compute @workgroup_size({LANES}, 1, 1)\n\
fn main(@builtin(global_invocation_id) id: vec3<u32>,\n\
        @builtin(subgroup_invocation_id) invocation: u32) {{\n\
    let lane = i32(invocation & 7u);\n\
    let x = i32(id.x) * {PIXELS};\n\
    let y = i32(id.y);\n\
    let block = i32(id.z);\n\
    let in_quads = i32(textureNumLayers(input));\n\
    let floor = {floor};\n\
    var row = 0;\n\
    var quad = 0;\n\
{accumulators}    for (var step = 0; step < {side} * in_quads; step++) {{\n\
{step}        quad += 1;\n\
        row += select(0, 1, quad == in_quads);\n\
        quad = select(quad, 0, quad == in_quads);\n\
    }}\n\
{store}}}\n",
        name = shape.name(),
        channels = quads * 4,
        accumulators = accumulators(quads),
        step = step(side, quads),
        store = store(shape, quads),
    )
}

fn accumulators(quads: usize) -> String {
    let mut text = String::new();
    for (k, p) in pairs(quads) {
        let _ = writeln!(text, "    var sum{k}_{p} = vec4<f32>();");
    }
    text
}

/// One kernel row of four input channels: loads, then all multiply-adds.
fn step(side: usize, quads: usize) -> String {
    let mut text = String::new();
    let border = side / 2;
    for i in 0..PIXELS as usize + side - 1 {
        let at = format!("vec2(x + {i} - {border}, y + row - {border})");
        let _ = writeln!(text, "        let in{i} = textureLoad(input, {at}, quad);");
    }
    for r in 0..(side * 4 * quads).div_ceil(LANES as usize) {
        let at = format!("vec2({} + lane, step)", r * LANES as usize);
        let _ = writeln!(text, "        let w{r} = textureLoad(weights, {at}, block);");
    }
    for k in 0..quads {
        for tap in 0..side * 4 {
            text += &broadcast(k, tap, quads);
        }
        for p in 0..PIXELS as usize {
            text += &multiply_add(k, p, side);
        }
    }
    text
}

fn broadcast(k: usize, tap: usize, quads: usize) -> String {
    let texel = tap * quads + k;
    let (register, lane) = (texel / LANES as usize, texel % LANES as usize);
    format!("        let b{k}_{tap} = subgroupBroadcast(w{register}, {lane}u);\n")
}

/// All taps of one accumulator in a row, so that it stays in a register meanwhile.
fn multiply_add(k: usize, p: usize, side: usize) -> String {
    let mut text = String::new();
    for tap in 0..side * 4 {
        let (column, channel) = (tap / 4, ["x", "y", "z", "w"][tap % 4]);
        let _ = writeln!(text, "        sum{k}_{p} += b{k}_{tap} * in{}.{channel};", p + column);
    }
    text
}

/// Bias, clamp and the guarded stores.
fn store(shape: Shape, quads: usize) -> String {
    let corners = shape.corners();
    let (scale, corner) =
        if corners == 4 { (2, "vec2(block % 2, block / 2 % 2)") } else { (1, "vec2(0, 0)") };
    let mut text = format!(
        "    let size = vec2<i32>(textureDimensions(output));\n\
    \x20   let out_quads = i32(textureNumLayers(output));\n\
    \x20   let first = block / {corners} * {quads};\n"
    );
    for (k, p) in pairs(quads) {
        let at = format!("vec2(x + {p}, y) * {scale} + {corner}");
        let value = format!("clamp(sum{k}_{p} + bias[first + {k}], vec4(floor), vec4(largest))");
        let _ = writeln!(
            text,
            "    if all({at} < size) && first + {k} < out_quads {{ \
             textureStore(output, {at}, first + {k}, {value}); }}"
        );
    }
    text
}

fn pairs(quads: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..quads).flat_map(|k| (0..PIXELS as usize).map(move |p| (k, p)))
}
