// The scale that brings an image to the exposure the network was trained at, as Open Image
// Denoise defines it: 0.18 / exp2(mean over bins of log2(mean luminance of the bin)). Made robust:
// bad pixels do not count, one pixel cannot move a bin by more than its second brightest allows, and
// what counts as unlit depends on the brightest bin, so that the scale follows any exposure.
// `bins` makes one bin per invocation, from a band of the image's rows; `reduce` then turns all
// bins into the scale, in a fixed order, so that the result does not depend on the bands.

import package::common::color::load_color;
import package::common::layout::Layout;
import package::common::light::{GREY, OUTLIER, is_finite, lit, luminance};

struct Band {
    image_size: vec2<u32>,   // of the whole image, pixels
    bins: vec2<u32>,         // of the whole image
    first_bin_row: u32,      // of this band
    bin_rows: u32,           // in this band
    first_row: u32,          // the image row at which the bound buffer begins
    padding: u32,
    color: Layout,
}

@group(0) @binding(0) var<uniform> band: Band;
@group(0) @binding(2) var<storage, read_write> log_luminance: array<f32>;
@group(0) @binding(3) var<storage, read_write> input_scale: f32;

const SMALLEST = 1.1754944e-38;   // smaller values are 0 on many GPUs
const RANGE = 33.0;          // bins 2^33 times darker than the brightest are unlit
const LONE = 1024.0;         // how far bins with a lone lit pixel stand below: more than any log2
const UNLIT = -4096.0;       // a bin without light

// −1 if the pixel is bad.
fn luminance_at(x: u32, y: u32) -> f32 {
    let bits = load_color(band.color, vec2(x, y - band.first_row));
    if !is_finite(bits) {
        return -1.0;
    }
    return luminance(lit(bitcast<vec3<f32>>(bits)));
}

@compute @workgroup_size(8, 8)
fn bins(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= band.bins.x || id.y >= band.bin_rows {
        return;
    }
    let bin = vec2(id.x, band.first_bin_row + id.y);
    let begin = bin * band.image_size / band.bins;
    let end = (bin + 1u) * band.image_size / band.bins;
    log_luminance[bin.y * band.bins.x + bin.x] = log_of_bin(begin, end);
}

// A lone lit pixel may be a firefly on a black background: bins that have nothing else stand far
// below the others, and so count only if all lit ones are such.
fn log_of_bin(begin: vec2<u32>, end: vec2<u32>) -> f32 {
    var count = 0u;
    var sum = 0.0;             // of all but the brightest
    var brightest = 0.0;
    var second = 0.0;
    for (var y = begin.y; y < end.y; y++) {
        for (var x = begin.x; x < end.x; x++) {
            let value = luminance_at(x, y);
            if value < 0.0 {
                continue;
            }
            count++;
            sum += min(value, brightest);
            second = max(second, min(value, brightest));
            brightest = max(brightest, value);
        }
    }
    let is_lone = count > 1u && second == 0.0;
    let most = select(OUTLIER * second, brightest, is_lone || count == 1u);
    let mean = (sum + min(brightest, most)) / f32(max(count, 1u));
    if mean < SMALLEST {
        return UNLIT;
    }
    return log2(mean) - select(0.0, LONE, is_lone);
}

const LANES = 256u;
var<workgroup> sums: array<f32, LANES>;
var<workgroup> counts: array<u32, LANES>;

// The most of all lanes' values.
fn maximum(lane: u32, value: f32) -> f32 {
    sums[lane] = value;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] = max(sums[lane], sums[lane + half]);
        }
    }
    return workgroupUniformLoad(&sums[0]);
}

@compute @workgroup_size(256)
fn reduce(@builtin(local_invocation_index) lane: u32) {
    let total = band.bins.x * band.bins.y;
    var most = UNLIT;
    for (var i = lane; i < total; i += LANES) {
        most = max(most, log_luminance[i]);
    }
    let brightest = maximum(lane, most);
    var sum = 0.0;
    var count = 0u;
    for (var i = lane; i < total; i += LANES) {
        let counted = log_luminance[i] > brightest - RANGE;
        sum += select(0.0, log_luminance[i] - brightest, counted);
        count += select(0u, 1u, counted);
    }
    sums[lane] = sum;
    counts[lane] = count;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
            counts[lane] += counts[lane + half];
        }
    }
    if lane == 0u {
        let offset = select(0.0, LONE, brightest < -0.5 * LONE);
        let mean = brightest + offset + sums[0] / f32(counts[0]);
        input_scale = select(GREY / exp2(mean), 1.0, brightest == UNLIT);
    }
}
