//! The text of the generated kernels.

use std::fmt::Write as _;

use super::walk::Walk;
use super::{LANES, SimdKernel};

/// The components of a texel.
const CHANNELS: [&str; 4] = ["x", "y", "z", "w"];

/// What the entry point needs of `shaders/`.
fn imports(shape: SimdKernel) -> &'static str {
    match shape {
        SimdKernel::Conv3x3 => {
            "import package::common::conv_output::{activated, bias, output};
import package::common::simd::{any_needed, weights};
import package::conv3x3_simd::input;"
        }
        SimdKernel::UpConv => {
            "import package::common::conv_output::{activated, bias, output};
import package::common::simd::{any_needed, weights};
import package::up_conv_simd::{low, skip};"
        }
        SimdKernel::Head => "import package::common::head::{finish, input, weights};",
        SimdKernel::ConvHead => {
            "import package::common::conv_head::{conv_bias, relu};
import package::common::head::{finish, input, weights};
import package::conv_head_simd::{any_needed, conv_weights};"
        }
    }
}

/// The entry point.
pub(super) fn source(shape: SimdKernel, quads: usize) -> String {
    let walks = shape.walks().iter().map(|walk| walk_text(shape, walk, quads));
    let needed = if shape == SimdKernel::Head { "true" } else { "any_needed(x, y)" };
    let tail = match shape {
        SimdKernel::Conv3x3 | SimdKernel::UpConv => store(shape, quads),
        SimdKernel::Head => finish("sum0_"),
        SimdKernel::ConvHead => project(quads) + &finish("result"),
    };
    format!(
        "{imports}

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
        imports = imports(shape),
        mask = LANES - 1,
        pixels = shape.pixels(),
        accumulators = accumulators(shape, quads),
        walks = walks.collect::<String>(),
    )
}

fn accumulators(shape: SimdKernel, quads: usize) -> String {
    let mut text = String::new();
    for (k, p) in pairs(shape, quads) {
        let _ = writeln!(text, "    var sum{k}_{p} = vec4<f32>();");
    }
    text
}

/// A loop over the steps of a walk: one kernel row of four input channels at a time.
fn walk_text(shape: SimdKernel, walk: &Walk, quads: usize) -> String {
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
fn step(shape: SimdKernel, walk: &Walk, quads: usize) -> String {
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

/// Biases and stores. What lies outside of the output is not stored.
fn store(shape: SimdKernel, quads: usize) -> String {
    let mut text = format!(
        "    if needed {{
    let size = vec2<i32>(textureDimensions(output));
    let out_quads = i32(textureNumLayers(output));
    let first = block * {quads};
    let vertical = select(select(1, 2, y == size.y - 1), 0, y == 0);
"
    );
    let bias = if shape == SimdKernel::UpConv { up_conv_bias } else { conv3x3_bias };
    for k in 0..quads {
        text += &bias(k);
        for p in 0..shape.pixels() {
            let value = format!("activated(sum{k}_{p} + bias{k}_{p})");
            let _ =
                writeln!(text, "    textureStore(output, vec2(x + {p}, y), first + {k}, {value});");
        }
    }
    text + "    }\n"
}

fn conv3x3_bias(k: usize) -> String {
    let mut text = format!("    let bias{k} = bias[first + {k}];\n");
    for p in 0..SimdKernel::Conv3x3.pixels() {
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
    for p in 0..SimdKernel::UpConv.pixels() {
        let right = format!("select(inside{k}, right{k}, x + {p} == size.x - 1)");
        let _ = writeln!(text, "    let bias{k}_{p} = select({right}, left{k}, x + {p} == 0);");
    }
    text
}

/// The 1×1 convolution of what the sums come to: the lanes load a quad's weights and hand them
/// round.
fn project(quads: usize) -> String {
    let pixels = SimdKernel::ConvHead.pixels();
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
    (0..SimdKernel::Head.pixels()).map(pixel).collect()
}

fn pairs(shape: SimdKernel, quads: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..quads).flat_map(move |k| (0..shape.pixels() as usize).map(move |p| (k, p)))
}
