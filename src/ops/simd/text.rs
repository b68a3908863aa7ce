//! The text of the generated kernels.

use std::fmt::Write as _;

use super::super::conv_head;
use super::super::image::ImageFormat;
use super::walk::Walk;
use super::{LANES, Shape};

/// The components of a texel.
const CHANNELS: [&str; 4] = ["x", "y", "z", "w"];

/// What every convolution declares after its tensors.
const NEED: &str = "
struct Need { layer: u32, shift: u32, reach: u32, padding: u32 }
override relu: bool;
// The largest value that the tensor's format holds: f32 to f16 does not saturate by itself.
override largest: f32;

// Whether any lane's pixels are needed: all lanes take the loops together, since each reads
// weights for the others.
fn any_needed(x: i32, y: i32) -> bool {
    let size = vec2<i32>(textureDimensions(output));
    let at = min(vec2(x, y), size - 1) >> vec2(need.shift);
    return subgroupAny(textureLoad(activity, at, need.layer, 0).x <= need.reach);
}
";

const CONV3X3: &str = "
alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
@group(0) @binding(2) var weights: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(4) var activity: texture_2d_array<u32>;
@group(0) @binding(5) var<uniform> need: Need;
";

const UP_CONV: &str = "
alias TensorIn = texture_storage_2d_array<rgba32float, read>;
alias TensorOut = texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(0) var skip: TensorIn;
@group(0) @binding(1) var low: TensorIn;
@group(0) @binding(2) var output: TensorOut;
@group(0) @binding(3) var weights: texture_storage_2d_array<rgba32float, read>;
// [above, inside, below][left, inside, right][output quad]
@group(0) @binding(4) var<storage, read> bias: array<vec4<f32>>;
@group(0) @binding(5) var activity: texture_2d_array<u32>;
@group(0) @binding(6) var<uniform> need: Need;
";

/// What follows the declarations of both variants of `conv_head`.
const CONV_HEAD: &str = "
@group(0) @binding(9) var conv_weights: texture_storage_2d_array<rgba32float, read>;

fn any_needed(x: i32, y: i32) -> bool {
    return subgroupAny(is_needed(vec2<u32>(vec2(x, y)), vec2(4u, 1u)));
}
";

/// What [`Shape::Conv3x3`] declares.
pub(super) fn conv3x3() -> String {
    format!("{CONV3X3}{NEED}")
}

/// What [`Shape::UpConv`] declares.
pub(super) fn up_conv() -> String {
    format!("{UP_CONV}{NEED}")
}

/// What [`Shape::ConvHead`] declares for a noisy colour and a result in these formats.
pub(super) fn conv_head(color: ImageFormat, output: ImageFormat) -> String {
    conv_head::declarations(color, output) + CONV_HEAD
}

/// The whole shader.
pub(super) fn source(shape: Shape, quads: usize, declarations: &str) -> String {
    let walks = shape.walks().iter().map(|walk| walk_text(shape, walk, quads));
    let needed = if shape == Shape::Head { "true" } else { "any_needed(x, y)" };
    let tail = match shape {
        Shape::Conv3x3 | Shape::UpConv => store(shape, quads),
        Shape::Head => finish("sum0_"),
        Shape::ConvHead => project(quads) + &finish("result"),
    };
    format!(
        "{declarations}
@compute @workgroup_size({LANES}, 1, 1)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(subgroup_invocation_id) invocation: u32,
) {{
    let lane = i32(invocation & {mask}u);
    let x = i32(id.x) * {pixels};
    let y = i32(id.y);
    let block = i32(id.z);
    let needed = {needed};
{accumulators}{walks}{tail}}}
",
        mask = LANES - 1,
        pixels = shape.pixels(),
        accumulators = accumulators(shape, quads),
        walks = walks.collect::<String>(),
    )
}

fn accumulators(shape: Shape, quads: usize) -> String {
    let mut text = String::new();
    for (k, p) in pairs(shape, quads) {
        let _ = writeln!(text, "    var sum{k}_{p} = vec4<f32>();");
    }
    text
}

/// A loop over the steps of a walk: one kernel row of four input channels at a time.
fn walk_text(shape: Shape, walk: &Walk, quads: usize) -> String {
    let Walk { tensor, rows, first_step, .. } = walk;
    format!(
        "    {{
    let in_quads = i32(textureNumLayers({tensor}));
    let first_step = {first_step};
    let steps = select(0, {rows} * in_quads, needed);
    var row = 0;
    var quad = 0;
    for (var step = 0; step < steps; step++) {{
{body}
        quad += 1;
        row += select(0, 1, quad == in_quads);
        quad = select(quad, 0, quad == in_quads);
    }}
    }}
",
        body = step(shape, walk, quads),
    )
}

/// Loads, then all multiply-adds.
fn step(shape: Shape, walk: &Walk, quads: usize) -> String {
    let Walk { tensor, weights, x, y, .. } = walk;
    let (pixels, lanes) = (shape.pixels() as usize, LANES as usize);
    let mut text = String::new();
    for i in 0..(walk.texels)(pixels) {
        let at = format!("vec2({x} + {i}, {y})");
        let _ = writeln!(text, "        let in{i} = textureLoad({tensor}, {at}, quad);");
    }
    for r in 0..(walk.taps * 4 * quads).div_ceil(lanes) {
        let at = format!("vec2({} + lane, first_step + step)", r * lanes);
        let _ = writeln!(text, "        let w{r} = textureLoad({weights}, {at}, block);");
    }
    for k in 0..quads {
        for tap in 0..walk.taps * 4 {
            let (register, lane) = ((tap * quads + k) / lanes, (tap * quads + k) % lanes);
            let _ =
                writeln!(text, "        let b{k}_{tap} = subgroupBroadcast(w{register}, {lane}u);");
        }
        for p in 0..pixels {
            text += &multiply_add(walk, k, p);
        }
    }
    text
}

/// All terms of one accumulator in a row, so that it stays in a register meanwhile.
fn multiply_add(walk: &Walk, k: usize, p: usize) -> String {
    let mut text = String::new();
    for (tap, texel) in (walk.terms)(p) {
        for (c, channel) in CHANNELS.into_iter().enumerate() {
            let weight = tap * 4 + c;
            let _ = writeln!(text, "        sum{k}_{p} += b{k}_{weight} * in{texel}.{channel};");
        }
    }
    text
}

/// Bias, clamp and stores. What lies outside of the output is not stored.
fn store(shape: Shape, quads: usize) -> String {
    let mut text = format!(
        "    if needed {{
    let size = vec2<i32>(textureDimensions(output));
    let out_quads = i32(textureNumLayers(output));
    let first = block * {quads};
    let floor = vec4(select(-largest, 0.0, relu));
    let vertical = select(select(1, 2, y == size.y - 1), 0, y == 0);
"
    );
    let bias = if shape == Shape::UpConv { up_conv_bias } else { conv3x3_bias };
    for k in 0..quads {
        text += &bias(k);
        for p in 0..shape.pixels() {
            let value = format!("stored(clamp(sum{k}_{p} + bias{k}_{p}, floor, vec4(largest)))");
            let _ =
                writeln!(text, "    textureStore(output, vec2(x + {p}, y), first + {k}, {value});");
        }
    }
    text + "    }\n"
}

fn conv3x3_bias(k: usize) -> String {
    let mut text = format!("    let bias{k} = bias[first + {k}];\n");
    for p in 0..Shape::Conv3x3.pixels() {
        let _ = writeln!(text, "    let bias{k}_{p} = bias{k};");
    }
    text
}

/// The transposed convolution's share of the bias is smaller where the zero padding is seen.
fn up_conv_bias(k: usize) -> String {
    let mut text = String::new();
    for (i, column) in ["left", "inside", "right"].into_iter().enumerate() {
        let index = format!("(vertical * 3 + {i}) * out_quads + first + {k}");
        let _ = writeln!(text, "    let {column}{k} = bias[{index}];");
    }
    for p in 0..Shape::UpConv.pixels() {
        let right = format!("select(inside{k}, right{k}, x + {p} == size.x - 1)");
        let _ = writeln!(text, "    let bias{k}_{p} = select({right}, left{k}, x + {p} == 0);");
    }
    text
}

/// The 1×1 convolution of what the sums come to: the lanes load a quad's weights and hand them
/// round.
fn project(quads: usize) -> String {
    let pixels = Shape::ConvHead.pixels();
    let mut text = String::new();
    for p in 0..pixels {
        let _ = writeln!(text, "    var result{p} = vec4<f32>();");
    }
    for k in 0..quads {
        let _ = writeln!(text, "    let bias{k} = conv_bias[{k}];");
        let _ = writeln!(text, "    let h{k} = textureLoad(weights, vec2(lane, {k}), 0);");
        for c in 0..4 {
            let _ = writeln!(text, "    let h{k}_{c} = subgroupBroadcast(h{k}, {c}u);");
        }
        for p in 0..pixels {
            let _ = writeln!(text, "    let value{k}_{p} = relu(sum{k}_{p} + bias{k});");
            for (c, channel) in CHANNELS.into_iter().enumerate() {
                let _ = writeln!(text, "    result{p} += h{k}_{c} * value{k}_{p}.{channel};");
            }
        }
    }
    text
}

/// The results, one per pixel, go on to the image by the function of the shader.
fn finish(result: &str) -> String {
    let pixel = |p| format!("    finish(vec2(x + {p}, y), {result}{p});\n");
    (0..Shape::Head.pixels()).map(pixel).collect()
}

fn pairs(shape: Shape, quads: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..quads).flat_map(move |k| (0..shape.pixels() as usize).map(move |p| (k, p)))
}
