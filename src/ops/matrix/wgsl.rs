//! Writes the text of the kernels.

use std::fmt::Write as _;

use super::{MatrixKernel, MatrixShape, SUBGROUPS, SUMS};

/// The entry point for a shape and a number of output channels per workgroup. Code that needs no
/// unrolling is in `shaders/`.
pub(super) fn source(kernel: MatrixKernel, shape: MatrixShape, channels: u32) -> String {
    let MatrixShape { side, lanes, .. } = shape;
    let invocations = lanes * SUBGROUPS;
    let imports = imports(kernel);
    let zeros = indented(4, &zeros(side, channels));
    let products = indented(12, &products(side, channels));
    let low = if kernel == MatrixKernel::UpConv { low(side, channels) } else { String::new() };
    let stores = indented(4, &stores(kernel, shape, channels));
    format!(
        "import package::common::matrix::{{
    CHANNELS, Factor, HEIGHT, QUADS, ROW, SIDE, SUMS, WIDTH,
    column, decide, input_slices, needed, pixels, put, stage, sums, weights
}};
{imports}
enable wgpu_cooperative_matrix;

alias Pixels = coop_mat{side}x{side}<Factor, A>;
alias Taps = coop_mat{side}x{side}<Factor, B>;
alias Sums = coop_mat{side}x{side}<f32, C>;
const LANES = {lanes}u;
const INVOCATIONS = {invocations}u;

@compute @workgroup_size(INVOCATIONS)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(subgroup_invocation_id) lane: u32,
) {{
    let corner = vec2<i32>(group.xy * vec2(WIDTH, HEIGHT));
    decide(corner, index);
    if !workgroupUniformLoad(&needed) {{
        return;
    }}
{zeros}    let slices = input_slices();
    for (var slice = 0u; slice < slices; slice++) {{
        workgroupBarrier();
        stage(corner, slice, index, INVOCATIONS);
        workgroupBarrier();
        for (var kx = 0u; kx < 3u; kx++) {{
            let taps = ((group.z * slices + slice) * 9u + kx) * CHANNELS * SIDE;
            let even = subgroup * 2u * ROW + column(kx);
            let odd = subgroup * 2u * ROW + column(kx + 1u);
{products}        }}
    }}
{low}    let at = corner + vec2(0, i32(subgroup * 2u));
    let quad = group.z * CHANNELS / 4u;
    let place = subgroup * SUMS;
{stores}}}
"
    )
}

fn imports(kernel: MatrixKernel) -> &'static str {
    match kernel {
        MatrixKernel::Conv3x3 { pools: false } | MatrixKernel::InputConv => "",
        MatrixKernel::Conv3x3 { pools: true } => "import package::conv3x3_matrix::pool;\n",
        MatrixKernel::UpConv => {
            "import package::up_conv_matrix::{LOW_ROW, low_slices, low_weights, stage_low};\n"
        }
        MatrixKernel::ConvLogits => "import package::conv_logits_matrix::put_logits;\n",
    }
}

fn indented(spaces: usize, text: &str) -> String {
    let margin = " ".repeat(spaces);
    text.lines().flat_map(|line| [&margin, line, "\n"]).collect()
}

/// The pixels of a square: row, then column.
const SQUARE: [(u32, u32); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

fn zeros(side: u32, channels: u32) -> String {
    let mut text = String::new();
    for (n, (row, column)) in (0..channels / side).flat_map(|n| SQUARE.map(|at| (n, at))) {
        let _ = writeln!(text, "var sum{row}{column}_{n} = Sums();");
    }
    text
}

/// The products of a slice and a kernel column `kx`: every staged row is loaded once and used by
/// every kernel row it belongs to.
fn products(side: u32, channels: u32) -> String {
    let tiles = channels / side;
    let mut text = String::new();
    for (ky, n) in (0..3).flat_map(|ky| (0..tiles).map(move |n| (ky, n))) {
        let tap = format!("tap{ky}_{n}");
        load_taps(&mut text, &tap, (ky * 3 * channels + n * side) * side);
    }
    for (y, (column, start)) in (0..4).flat_map(|y| [(y, (0, "even")), (y, (1, "odd"))]) {
        let pixels = format!("in{y}{column}");
        let load = format!("coopLoadT<Pixels>(&pixels[{start} + {y}u * ROW], SIDE)");
        let _ = writeln!(text, "let {pixels} = {load};");
        for (row, n) in (0..2).flat_map(|row| (0..tiles).map(move |n| (row, n))) {
            if (row..row + 3).contains(&y) {
                let tap = format!("tap{}_{n}", y - row);
                multiply(&mut text, &pixels, &tap, &format!("sum{row}{column}_{n}"));
            }
        }
    }
    text
}

/// The loop over slices of the low-resolution tensor. Each of the four pixels of a square sees 2×2
/// of the 3×3 low-resolution pixels around it, with taps of its own.
fn low(side: u32, channels: u32) -> String {
    let products = indented(8, &low_products(side, channels));
    format!(
        "    let lows = low_slices();
    for (var slice = 0u; slice < lows; slice++) {{
        workgroupBarrier();
        stage_low(corner / 2, slice, index, INVOCATIONS);
        workgroupBarrier();
        let taps = low_weights() + (group.z * lows + slice) * 16u * CHANNELS * SIDE;
{products}    }}
"
    )
}

fn low_products(side: u32, channels: u32) -> String {
    let mut text = String::new();
    for (y, x) in (0..3).flat_map(|y| (0..3).map(move |x| (y, x))) {
        let at = format!("(subgroup + {y}u) * LOW_ROW + {}u", x * side);
        let load = format!("coopLoadT<Pixels>(&pixels[{at}], SIDE)");
        let _ = writeln!(text, "let in{y}{x} = {load};");
    }
    let taps = SQUARE.into_iter().flat_map(|of| SQUARE.map(|tap| (of, tap)));
    for (i, ((row, column), (y, x))) in (0..).zip(taps) {
        for n in 0..channels / side {
            let tap = format!("tap{i}_{n}");
            load_taps(&mut text, &tap, (i * channels + n * side) * side);
            let pixels = format!("in{}{}", row + y, column + x);
            multiply(&mut text, &pixels, &tap, &format!("sum{row}{column}_{n}"));
        }
    }
    text
}

fn load_taps(text: &mut String, name: &str, at: u32) {
    let load = format!("coopLoad<Taps>(&weights[taps + {at}u], SIDE)");
    let _ = writeln!(text, "let {name} = {load};");
}

fn multiply(text: &mut String, pixels: &str, tap: &str, sum: &str) {
    let _ = writeln!(text, "{sum} = coopMultiplyAdd({pixels}, {tap}, {sum});");
}

/// Stores the sums, as many matrices at a time as fit into workgroup memory: the four pixels of
/// each square one after another, then their maximum.
fn stores(kernel: MatrixKernel, shape: MatrixShape, channels: u32) -> String {
    let MatrixShape { side, lanes, .. } = shape;
    let together = (SUMS / (side * side)).min(channels / side);
    // Quads of the sums in flight that an invocation finishes.
    let held = (together * side * side / 4).div_ceil(lanes);
    let mut text = String::new();
    for first in (0..channels / side).step_by(together as usize) {
        let quad = format!("quad + {}u", first * side / 4);
        for (row, column) in SQUARE {
            for n in 0..together {
                let (sum, offset) = (format!("sum{row}{column}_{}", first + n), n * side * side);
                let _ = writeln!(text, "coopStore({sum}, &sums[place + {offset}u], SIDE);");
            }
            let at = format!("at + vec2({column}, {row})");
            let value = format!("value{first}_{row}{column}");
            let puts = puts(kernel, &at, &quad, &value, held);
            text = text + "workgroupBarrier();\n" + &puts + "workgroupBarrier();\n";
        }
        for k in (0..held).filter(|_| kernel == MatrixKernel::Conv3x3 { pools: true }) {
            let [a, b, c, d] = SQUARE.map(|(y, x)| format!("value{first}_{y}{x}_{k}"));
            let most = format!("max(max({a}, {b}), max({c}, {d}))");
            let _ = writeln!(text, "pool(at, {quad}, lane + {k}u * LANES, {most});");
        }
    }
    text
}

/// Stores the sums in flight, which belong to one pixel of each square.
fn puts(kernel: MatrixKernel, at: &str, quad: &str, value: &str, held: u32) -> String {
    if kernel == MatrixKernel::ConvLogits {
        return format!("put_logits({at}, place, lane, LANES);\n");
    }
    let put = |k| format!("let {value}_{k} = put({at}, {quad}, place, lane + {k}u * LANES);\n");
    (0..held).map(put).collect()
}
