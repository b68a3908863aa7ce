//! The text of the kernel.

use std::fmt::Write as _;

use super::{COLUMNS, MatrixShape, ROWS, SUBGROUPS, SUMS};

/// The entry point for a shape and a number of output channels per workgroup. What needs no
/// unrolling is in `shaders/conv3x3_matrix.wgsl`.
pub(super) fn source(shape: MatrixShape, channels: u32) -> String {
    let body = [zeros(shape, channels), products(shape, channels), stores(shape, channels)];
    let [zeros, products, stores] = body;
    let MatrixShape { side, lanes, .. } = shape;
    let invocations = lanes * SUBGROUPS;
    format!(
        "import package::conv3x3_matrix::{{
    CHANNELS, Factor, HEIGHT, QUADS, ROWS, SIDE, STAGED_WIDTH, SUMS, WIDTH,
    input, pixels, put, stage, sums, weights
}};

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
    let slices = (textureNumLayers(input) + QUADS - 1u) / QUADS;
    let row = subgroup * ROWS;
{zeros}    for (var slice = 0u; slice < slices; slice++) {{
        workgroupBarrier();
        stage(corner, slice, index, INVOCATIONS);
        workgroupBarrier();
        for (var kx = 0u; kx < 3u; kx++) {{
            let taps = ((group.z * slices + slice) * 9u + kx) * CHANNELS * SIDE;
            let first = (row * STAGED_WIDTH + kx) * SIDE;
{products}        }}
    }}
    let quad = group.z * CHANNELS / 4u;
    let place = subgroup * SUMS;
{stores}}}
"
    )
}

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
            let put = format!("put({at}, quad + {quad}u, place, lane, LANES);");
            let _ = writeln!(text, "    workgroupBarrier();\n    {put}\n    workgroupBarrier();");
        }
    }
    text
}
