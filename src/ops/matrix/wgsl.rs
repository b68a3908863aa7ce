//! The text of the kernel.

use std::fmt::Write as _;

use super::{COLUMNS, Factor, MatrixShape, ROWS, SUBGROUPS, SUMS};

/// The WGSL for a shape and a number of output channels per workgroup.
pub(super) fn source(shape: MatrixShape, channels: u32) -> String {
    let body = [zeros(shape, channels), products(shape, channels), stores(shape, channels)];
    let [zeros, products, stores] = body;
    let header = header(shape, channels);
    format!(
        "{header}\n{FUNCTIONS}\n\
@compute @workgroup_size(INVOCATIONS)\n\
fn main(\n\
    @builtin(workgroup_id) group: vec3<u32>,\n\
    @builtin(local_invocation_index) index: u32,\n\
    @builtin(subgroup_id) subgroup: u32,\n\
    @builtin(subgroup_invocation_id) lane: u32,\n\
) {{\n\
    let corner = vec2<i32>(group.xy * vec2(WIDTH, HEIGHT));\n\
    let slices = (textureNumLayers(input) + QUADS - 1u) / QUADS;\n\
    let row = subgroup * ROWS;\n\
{zeros}\
    for (var slice = 0u; slice < slices; slice++) {{\n\
        workgroupBarrier();\n\
        stage(corner, slice, index);\n\
        workgroupBarrier();\n\
        for (var kx = 0u; kx < 3u; kx++) {{\n\
            let taps = ((group.z * slices + slice) * 9u + kx) * CHANNELS * SIDE;\n\
            let first = (row * STAGED_WIDTH + kx) * SIDE;\n\
{products}\
        }}\n\
    }}\n\
    let quad = group.z * CHANNELS / 4u;\n\
    let place = subgroup * SUMS;\n\
{stores}\
}}\n"
    )
}

fn header(shape: MatrixShape, channels: u32) -> String {
    let MatrixShape { side, lanes, .. } = shape;
    let [width, height] = [COLUMNS * side, SUBGROUPS * ROWS];
    let staged = (width + 2) * (height + 2);
    let (factor, enable, largest) = match shape.factor {
        Factor::F16 => ("f16", "enable f16;\n", "65504.0"),
        Factor::F32 => ("f32", "", "0x1.fffffep+127"),
    };
    format!(
        "// 3×3 convolution by matrices of {side}×{side} {factor}, in subgroups of {lanes}.\n\
{enable}enable wgpu_cooperative_matrix;\n\
alias TensorIn = texture_storage_2d_array<rgba32float, read>;\n\
alias TensorOut = texture_storage_2d_array<rgba32float, write>;\n\
alias Factor = {factor};\n\
alias Pixels = coop_mat{side}x{side}<{factor}, A>;\n\
alias Taps = coop_mat{side}x{side}<{factor}, B>;\n\
alias Sums = coop_mat{side}x{side}<f32, C>;\n\
const LARGEST_FACTOR = {largest};\n\
const SIDE = {side}u;\n\
const QUADS = {quads}u;\n\
const CHANNELS = {channels}u;\n\
const LANES = {lanes}u;\n\
const INVOCATIONS = {invocations}u;\n\
const ROWS = {ROWS}u;\n\
const WIDTH = {width}u;\n\
const HEIGHT = {height}u;\n\
const STAGED_WIDTH = {staged_width}u;\n\
const STAGED = {staged}u;\n\
const SUMS = {SUMS}u;\n\
const SUMS_USED = {used}u;\n\
var<workgroup> pixels: array<Factor, {factors}>;\n\
var<workgroup> sums: array<f32, {sums}>;\n",
        quads = side / 4,
        invocations = lanes * SUBGROUPS,
        staged_width = width + 2,
        used = side * side * tiles_per_store(side, channels),
        factors = staged * side,
        sums = SUBGROUPS * SUMS,
    )
}

/// What needs no unrolling. What is staged beyond the image or its channels is 0, and so are the
/// weights of channels that do not exist.
const FUNCTIONS: &str = "\
@group(0) @binding(0) var input: TensorIn;
@group(0) @binding(1) var output: TensorOut;
@group(0) @binding(2) var<storage, read> weights: array<Factor>;
@group(0) @binding(3) var<storage, read> bias: array<vec4<f32>>;
override relu: bool;
override largest: f32;

fn stage(corner: vec2<i32>, slice: u32, index: u32) {
    let size = vec2<i32>(textureDimensions(input));
    let in_quads = textureNumLayers(input);
    for (var i = index; i < STAGED * QUADS; i += INVOCATIONS) {
        let quad = slice * QUADS + i % QUADS;
        let at = corner + vec2<i32>(vec2(i / QUADS % STAGED_WIDTH, i / QUADS / STAGED_WIDTH)) - 1;
        let inside = all(at >= vec2(0)) && all(at < size) && quad < in_quads;
        let texel = textureLoad(input, clamp(at, vec2(0), size - 1), min(quad, in_quads - 1u));
        let most = vec4(LARGEST_FACTOR);
        let value = vec4<Factor>(clamp(select(vec4<f32>(), texel, inside), -most, most));
        pixels[i * 4u] = value.x;
        pixels[i * 4u + 1u] = value.y;
        pixels[i * 4u + 2u] = value.z;
        pixels[i * 4u + 3u] = value.w;
    }
}

fn finish(sum: vec4<f32>, at: vec2<i32>, quad: u32) {
    let inside = all(at < vec2<i32>(textureDimensions(output)));
    if inside && quad < textureNumLayers(output) {
        let floor = select(-largest, 0.0, relu);
        let value = clamp(sum + bias[quad], vec4(floor), vec4(largest));
        textureStore(output, at, quad, stored(value));
    }
}

// Sums are [output channel][pixel of a row].
fn put(at: vec2<i32>, quad: u32, place: u32, lane: u32) {
    for (var i = lane; i < SUMS_USED / 4u; i += LANES) {
        let x = i % SIDE;
        let first = place + i / SIDE * 4u * SIDE + x;
        let below = vec2(sums[first], sums[first + SIDE]);
        let above = vec2(sums[first + 2u * SIDE], sums[first + 3u * SIDE]);
        finish(vec4(below, above), at + vec2(i32(x), 0), quad + i / SIDE);
    }
}
";

/// Tiles of output channels that go to the output together.
fn tiles_per_store(side: u32, channels: u32) -> u32 {
    (SUMS / (side * side)).min(channels / side)
}

/// Row, tile of columns and tile of output channels of every accumulator of a subgroup.
fn accumulators(side: u32, channels: u32) -> impl Iterator<Item = (u32, u32, u32)> {
    let columns = move |row| (0..COLUMNS).map(move |column| (row, column));
    let place = (0..ROWS).flat_map(columns);
    place.flat_map(move |(row, column)| (0..channels / side).map(move |n| (row, column, n)))
}

fn zeros(shape: MatrixShape, channels: u32) -> String {
    let mut text = String::new();
    for (row, column, n) in accumulators(shape.side, channels) {
        let _ = writeln!(text, "    var sum{row}_{column}_{n} = Sums();");
    }
    text
}

/// The products of a slice and a kernel column `kx`: every staged row is loaded once and used by
/// each kernel row that it belongs to.
fn products(shape: MatrixShape, channels: u32) -> String {
    let (side, tiles) = (shape.side, channels / shape.side);
    let mut text = String::new();
    for (ky, n) in (0..3).flat_map(|ky| (0..tiles).map(move |n| (ky, n))) {
        let at = (ky * 3 * channels + n * side) * side;
        let load = format!("coopLoad<Taps>(&weights[taps + {at}u], SIDE)");
        let _ = writeln!(text, "            let tap{ky}_{n} = {load};");
    }
    for (row, column) in (0..ROWS + 2).flat_map(|r| (0..COLUMNS).map(move |c| (r, c))) {
        let at = format!("first + ({row}u * STAGED_WIDTH + {}u) * SIDE", column * side);
        let load = format!("coopLoadT<Pixels>(&pixels[{at}], SIDE)");
        let _ = writeln!(text, "            let in{row}_{column} = {load};");
        for ky in (0..3).filter(|ky| (*ky..ky + ROWS).contains(&row)) {
            for n in 0..tiles {
                let sum = format!("sum{}_{column}_{n}", row - ky);
                let product = format!("coopMultiplyAdd(in{row}_{column}, tap{ky}_{n}, {sum})");
                let _ = writeln!(text, "            {sum} = {product};");
            }
        }
    }
    text
}

fn stores(shape: MatrixShape, channels: u32) -> String {
    let side = shape.side;
    let together = tiles_per_store(side, channels);
    let mut text = String::new();
    for (row, column, n) in accumulators(side, channels) {
        let offset = n % together * side * side;
        let sum = format!("sum{row}_{column}_{n}");
        let _ = writeln!(text, "    coopStore({sum}, &sums[place + {offset}u], SIDE);");
        if n % together == together - 1 {
            let at = format!("corner + vec2({}, i32(row + {row}u))", column * side);
            let quad = (n + 1 - together) * side / 4;
            let put = format!("put({at}, quad + {quad}u, place, lane);");
            let _ = writeln!(text, "    workgroupBarrier();\n    {put}\n    workgroupBarrier();");
        }
    }
    text
}
