//! Writes the text of the generated kernels.

use std::fmt::Write as _;

use super::walk::Walk;
use super::{LANES, SimdKernel};

/// The components of a texel.
const CHANNELS: [&str; 4] = ["x", "y", "z", "w"];

/// The entry point's imports from `shaders/`.
fn imports(shape: SimdKernel) -> &'static str {
    match shape {
        SimdKernel::Conv1x1 | SimdKernel::Conv3x3 => {
            "import package::common::conv_output::{activated, bias, output};
import package::common::simd::{any_needed, weights};
import package::common::simd_input::input;"
        }
        SimdKernel::UpConv => {
            "import package::common::conv_output::{activated, bias, output};
import package::common::simd::{any_needed, weights};
import package::up_conv_simd::{low, skip};"
        }
        SimdKernel::Head => "import package::common::head::{finish, input, weights};",
        SimdKernel::ConvLogits => {
            "import package::common::conv_logits::{feature_of, logits_bias};
import package::common::conv_output::{activated, bias, output};
import package::common::simd::{any_needed, weights};
import package::common::simd_input::input;
import package::conv_logits_simd::logits_weights;"
        }
    }
}

/// The entry point.
pub(super) fn source(shape: SimdKernel, quads: usize) -> String {
    let walks = shape.walks().iter().map(|walk| walk_text(shape, walk, quads));
    let needed = if shape == SimdKernel::Head { "true" } else { "any_needed(x, y)" };
    let tail = match shape {
        SimdKernel::Conv1x1 | SimdKernel::Conv3x3 | SimdKernel::UpConv => store(shape, quads),
        SimdKernel::Head => finish(),
        SimdKernel::ConvLogits => logits(quads),
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

/// All terms of one accumulator in a row, so that it stays in a register.
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

/// Biases and stores. Pixels outside the output are not stored.
fn store(shape: SimdKernel, quads: usize) -> String {
    let mut text = format!(
        "    if needed {{
    let size = vec2<i32>(textureDimensions(output));
    let out_quads = i32(textureNumLayers(output));
    let first = block * {quads};
    let vertical = select(select(1, 2, y == size.y - 1), 0, y == 0);
"
    );
    let bias = if shape == SimdKernel::UpConv { up_conv_bias } else { plain_bias };
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

fn plain_bias(k: usize) -> String {
    let mut text = format!("    let bias{k} = bias[first + {k}];\n");
    for p in 0..SimdKernel::Conv3x3.pixels() {
        let _ = writeln!(text, "    let bias{k}_{p} = bias{k};");
    }
    text
}

/// The transposed convolution's share of the bias is smaller where the kernel sees the zero
/// padding.
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

/// The 1×1 convolution of the activated sums, and its stores: for four logits at a time, the lanes
/// load a quad's weights and share them.
fn logits(quads: usize) -> String {
    let mut text = String::new();
    for (k, p) in pairs(SimdKernel::ConvLogits, quads) {
        let _ = writeln!(text, "    let value{k}_{p} = feature_of(sum{k}_{p} + bias[{k}]);");
    }
    format!(
        "{text}    let out_quads = select(0, i32(textureNumLayers(output)), needed);
    for (var out = 0; out < out_quads; out++) {{
{body}    }}
",
        body = four_logits(quads),
    )
}

fn four_logits(quads: usize) -> String {
    let pixels = SimdKernel::ConvLogits.pixels();
    let mut text = String::new();
    for p in 0..pixels {
        let _ = writeln!(text, "        var logits{p} = logits_bias[out];");
    }
    for k in 0..quads {
        let at = format!("vec2(lane & 3, {k})");
        let _ = writeln!(text, "        let h{k} = textureLoad(logits_weights, {at}, out);");
        for (c, channel) in CHANNELS.into_iter().enumerate() {
            let _ = writeln!(text, "        let h{k}_{c} = subgroupBroadcast(h{k}, {c}u);");
            for p in 0..pixels {
                let _ = writeln!(text, "        logits{p} += h{k}_{c} * value{k}_{p}.{channel};");
            }
        }
    }
    for p in 0..pixels {
        let value = format!("activated(logits{p})");
        let _ = writeln!(text, "        textureStore(output, vec2(x + {p}, y), out, {value});");
    }
    text
}

/// Passes the sums, one per pixel, to the shader's function that stores them in the image.
fn finish() -> String {
    let pixel = |p| format!("    finish(vec2(x + {p}, y), sum0_{p});\n");
    (0..SimdKernel::Head.pixels()).map(pixel).collect()
}

fn pairs(shape: SimdKernel, quads: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..quads).flat_map(move |k| (0..shape.pixels() as usize).map(move |p| (k, p)))
}
