// The scale that brings an image to the exposure the network was trained at, as Open Image
// Denoise defines it: 0.18 / exp2(mean over bins of log2(mean luminance of the bin)).
// `bins` makes one bin per invocation, from a band of the image's rows; `reduce` then turns all
// bins into the scale, in a fixed order, so that the result does not depend on the bands.

struct Band {
    image_size: vec2<u32>,   // of the whole image, pixels
    bins: vec2<u32>,         // of the whole image
    first_bin_row: u32,      // of this band
    bin_rows: u32,           // in this band
    first_row: u32,          // the image row at which the bound buffer begins
    color: vec4<u32>,        // offset, row stride, pixel stride, in elements
}

@group(0) @binding(0) var<uniform> band: Band;
// Binding 1: the image `color`, read by a text of shaders/image.
@group(0) @binding(2) var<storage, read_write> log_luminance: array<f32>;
@group(0) @binding(3) var<storage, read_write> input_scale: f32;

const KEY = 0.18;
const DARKEST = 1e-8;        // bins of less luminance are background and do not count
const NOT_COUNTED = 1e9;     // no log2 of an f32 comes near it
const BRIGHTEST = 1e30;      // sums of a bin and 65504 ÷ scale stay within f32

fn sanitise(bits: u32) -> f32 {
    let finite = (bits & 0x7f800000u) != 0x7f800000u;
    return clamp(bitcast<f32>(select(0u, bits, finite)), 0.0, BRIGHTEST);
}

fn luminance(x: u32, y: u32) -> f32 {
    let bits = load_color(vec2(x, y - band.first_row));
    let rgb = vec3(sanitise(bits.r), sanitise(bits.g), sanitise(bits.b));
    return dot(rgb, vec3(0.212671, 0.715160, 0.072169));
}

@compute @workgroup_size(8, 8)
fn bins(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= band.bins.x || id.y >= band.bin_rows {
        return;
    }
    let bin = vec2(id.x, band.first_bin_row + id.y);
    let begin = bin * band.image_size / band.bins;
    let end = (bin + 1u) * band.image_size / band.bins;
    var sum = 0.0;
    for (var y = begin.y; y < end.y; y++) {
        for (var x = begin.x; x < end.x; x++) {
            sum += luminance(x, y);
        }
    }
    let mean = sum / f32((end.x - begin.x) * (end.y - begin.y));
    let log_mean = select(NOT_COUNTED, log2(max(mean, DARKEST)), mean > DARKEST);
    log_luminance[bin.y * band.bins.x + bin.x] = log_mean;
}

const LANES = 256u;
var<workgroup> sums: array<f32, LANES>;
var<workgroup> counts: array<u32, LANES>;

@compute @workgroup_size(256)
fn reduce(@builtin(local_invocation_index) lane: u32) {
    let total = band.bins.x * band.bins.y;
    var sum = 0.0;
    var count = 0u;
    for (var i = lane; i < total; i += LANES) {
        let counted = log_luminance[i] < NOT_COUNTED;
        sum += select(0.0, log_luminance[i], counted);
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
        let mean = sums[0] / f32(max(counts[0], 1u));
        input_scale = select(1.0, KEY / exp2(mean), counts[0] > 0u);
    }
}
