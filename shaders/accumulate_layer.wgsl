// Averages a further layer of the image with its last frames, using the weights that `accumulate`
// finds for its beauty, so that layers that add up to the beauty still do. Before `accumulate`,
// `soften` makes it read the beauty as softly as the layer must be read; after it, `average` stores
// the mean. One pixel of the image per invocation.

import package::common::light::is_finite;
import package::common::mean::mean_with;
import package::common::motion::last_place;
import package::common::output::store;
import package::common::spline::{
    Reading, nothing_read, pixel_at, sharpened, sharpness, weights_at, with_pixel,
};
import package::common::tile::tile;

// The history that this frame leaves for the beauty, laid out as in `history`.
@group(0) @binding(3) var<storage, read_write> beauty: array<u32>;
// The mean of the last frames; w is 1 if there is one, else 0.
@group(0) @binding(4) var<storage, read> last: array<vec4<f32>>;
// The denoised layer with its alpha, then the next frame's `last`.
@group(0) @binding(5) var<storage, read_write> next: array<vec4<f32>>;

const COUNT = 3u;            // the beauty's plane with the number of frames that count

fn index_of(at: vec2<u32>) -> u32 {
    return at.y * tile.image_size.x + at.x;
}

fn count_word(at: vec2<u32>) -> u32 {
    return COUNT * tile.image_size.x * tile.image_size.y + index_of(at);
}

// Softness is the beauty's last plane.
fn softness_word(at: vec2<u32>) -> u32 {
    return arrayLength(&beauty) - tile.image_size.x * tile.image_size.y + index_of(at);
}

fn reading_for(at: vec2<u32>) -> Reading {
    let place = last_place(at).xy;
    let weights = weights_at(place);
    var reading = nothing_read();
    for (var i = 0u; i < 16u; i++) {
        let step = vec2(i % 4u, i / 4u);
        reading = with_pixel(reading, weights, step, last[index_of(pixel_at(place, step))]);
    }
    return reading;
}

@compute @workgroup_size(8, 8)
fn soften(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= tile.image_size) {
        return;
    }
    let word = softness_word(id.xy);
    let softness = max(bitcast<f32>(beauty[word]), 1.0 - sharpness(reading_for(id.xy)));
    beauty[word] = bitcast<u32>(softness);
}

@compute @workgroup_size(8, 8)
fn average(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= tile.image_size) {
        return;
    }
    let i = index_of(id.xy);
    let frame = next[i];
    let reading = reading_for(id.xy);
    let past = sharpened(reading, 1.0 - bitcast<f32>(beauty[softness_word(id.xy)]));
    let count = bitcast<f32>(beauty[count_word(id.xy)]);
    let frames = select(0.0, count - 1.0, count > 0.0 && reading.linear.w > 0.0);
    let color = mean_with(past, frames, frame.rgb).rgb;
    store(id.xy, color, frame.a);
    let is_kept = count > 0.0 && is_finite(bitcast<vec3<u32>>(color));
    next[i] = select(vec4(0.0), vec4(color, 1.0), is_kept);
}
