// Stages level 0 for a workgroup of `gather`: its 32×8 pixels and a border of one pixel, each
// computed once.

import package::common::finest::finest;
import package::common::weighted::{Pixel, color_layer, pixel_of};
@if(demodulates) import package::common::weighted::albedo_layer;

const GROUP_WIDTH = 32i;
const GROUP_HEIGHT = 8i;
const INVOCATIONS = 64i;
const STEP = 4i;             // from an invocation's first pixel to its neighbor's
const STAGED_WIDTH = 34;
const STAGED_HEIGHT = 10;
const ROW = STEP * 9;        // elements

var<workgroup> staged_color: array<vec4<f32>, ROW * STAGED_HEIGHT>;
@if(demodulates) var<workgroup> staged_albedo: array<vec4<f32>, ROW * STAGED_HEIGHT>;

// The top left pixel of the border.
var<private> corner: vec2<i32>;

// Invocations read every fourth pixel at the same time, so these lie next to each other: at a
// distance of four, they would share memory banks.
fn element_at(pixel: vec2<i32>) -> i32 {
    return pixel.y * ROW + pixel.x % STEP * (ROW / STEP) + pixel.x / STEP;
}

// Beyond the edge of a level of `size` pixels, pixels repeat.
fn stage(group: vec2<i32>, invocation: u32, size: vec2<i32>) {
    corner = group * vec2(GROUP_WIDTH, GROUP_HEIGHT) - 1;
    for (var i = i32(invocation); i < STAGED_WIDTH * STAGED_HEIGHT; i += INVOCATIONS) {
        let at = vec2(i % STAGED_WIDTH, i / STAGED_WIDTH);
        let pixel = finest(vec2<u32>(clamp(corner + at, vec2(0), size - 1)));
        let element = element_at(at);
        staged_color[element] = color_layer(pixel);
        @if(demodulates)
        staged_albedo[element] = albedo_layer(pixel);
    }
    workgroupBarrier();
}

fn staged(pixel: vec2<i32>) -> Pixel {
    let element = element_at(pixel - corner);
    @if(demodulates)
    return pixel_of(staged_color[element], staged_albedo[element]);
    @else
    return pixel_of(staged_color[element]);
}
