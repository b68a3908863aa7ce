// The scale that brings an image to the exposure the network was trained at, as Open Image Denoise
// defines it: 0.18 / exp2(mean over bins of log2(mean luminance of the bin)). For robustness, bad
// pixels do not count, one pixel cannot move a bin by more than the second brightest allows, and
// bins far darker than the bright ones, such as a background or a letterbox, have no weight. `bins`
// computes one bin per invocation, from a band of the image's rows. `reduce` then turns all bins
// into the scale, in a fixed order, so that the result does not depend on the bands.

import package::common::color::load_color;
import package::common::layout::Layout;
import package::common::light::{GREY, is_finite, lit, luminance};

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
const SPIKE = 16.0;          // a bin's brightest pixel counts as at most this many times the second
const LONE = 1024.0;         // offset of bins with a lone lit pixel: more than any log2
const UNLIT = -4096.0;       // a bin without light
const NO_WEIGHT = -11.0;     // at this distance from a bright bin, in powers of two, weight is 0,
const FADE = 2.0;            // and this much above that, it is full

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

// A lone lit pixel may be a firefly on a black background. Bins with nothing else are stored far
// below the others, so that they count only if all lit bins are such bins.
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
    let most = select(SPIKE * second, brightest, is_lone || count == 1u);
    let mean = (sum + min(brightest, most)) / f32(max(count, 1u));
    if mean < SMALLEST {
        return UNLIT;
    }
    return log2(mean) - select(0.0, LONE, is_lone);
}

// Keys sort like the values.
fn key_of(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn value_of(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key & 0x7fffffffu, key >= 0x80000000u));
}

const LANES = 256u;
const DIGITS = 16u;          // of a key, two bits each
// The number of keys below each threshold of `value_at`, three per digit; then of lit and of lone
// bins. Every count has a place of its own, so that one barrier per digit is enough.
const COUNTS = 3u * DIGITS + 2u;
var<workgroup> counts: array<atomic<u32>, COUNTS>;
var<workgroup> sums: array<vec2<f32>, LANES>;

fn bin_count() -> u32 {
    return band.bins.x * band.bins.y;
}

// The bins that matter: all lit ones that are not lone, or else the lone ones.
fn candidates(lane: u32) -> u32 {
    var lit = 0u;
    var lone = 0u;
    for (var i = lane; i < bin_count(); i += LANES) {
        let value = log_luminance[i];
        let is_lone = value < -0.5 * LONE;
        lit += select(1u, 0u, is_lone);
        lone += select(0u, 1u, is_lone && value != UNLIT);
    }
    atomicAdd(&counts[3u * DIGITS], lit);
    atomicAdd(&counts[3u * DIGITS + 1u], lone);
    workgroupBarrier();
    let all_lit = atomicLoad(&counts[3u * DIGITS]);
    return select(all_lit, atomicLoad(&counts[3u * DIGITS + 1u]), all_lit == 0u);
}

// The value with `rank` others below it. Finds its key digit by digit, from the highest down, by
// counting the keys below each choice.
fn value_at(rank: u32, lane: u32) -> f32 {
    var key = 0u;
    for (var digit = 0u; digit < DIGITS; digit++) {
        let step = 1u << (2u * (DIGITS - 1u - digit));
        let choices = key + step * vec3(1u, 2u, 3u);
        var below = vec3<u32>();
        for (var i = lane; i < bin_count(); i += LANES) {
            below += select(vec3(0u), vec3(1u), vec3(key_of(log_luminance[i])) < choices);
        }
        for (var choice = 0u; choice < 3u; choice++) {
            atomicAdd(&counts[3u * digit + choice], below[choice]);
        }
        workgroupBarrier();
        for (var choice = 0u; choice < 3u; choice++) {
            key += select(0u, step, atomicLoad(&counts[3u * digit + choice]) <= rank);
        }
    }
    return value_of(key);
}

// The sum over all lanes, at lane 0.
fn total(lane: u32, share: vec2<f32>) -> vec2<f32> {
    sums[lane] = share;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    return sums[lane];
}

// Unlit bins sort below lone ones, and lone ones below the others, so a rank among the candidates
// becomes one among all bins, and bins that are not candidates are too dark to have weight.
@compute @workgroup_size(256)
fn reduce(@builtin(local_invocation_index) lane: u32) {
    // Workgroup memory is not zero-initialized here.
    if lane < COUNTS {
        atomicStore(&counts[lane], 0u);
    }
    workgroupBarrier();
    let count = candidates(lane);
    let rank = bin_count() - count + (max(count, 1u) - 1u) * 19u / 20u;
    let bright = value_at(rank, lane);
    var sum = vec2<f32>();
    for (var i = lane; i < bin_count(); i += LANES) {
        let offset = log_luminance[i] - bright;
        let weight = saturate((offset - NO_WEIGHT) / FADE);
        sum += weight * vec2(offset, 1.0);
    }
    let all = total(lane, sum);
    if lane == 0u {
        let lone = select(0.0, LONE, bright < -0.5 * LONE);
        let mean = bright + lone + all.x / all.y;
        input_scale = select(GREY / exp2(mean), 1.0, count == 0u);
    }
}
