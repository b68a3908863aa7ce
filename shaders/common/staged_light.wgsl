// Level 0 of the pixels that a workgroup of `gather` reads, each computed once: 32×8 pixels and those
// around them.

import package::common::finest::finest;
import package::common::weighted::{Pixel, color_layer, pixel_of};
@if(demodulates) import package::common::weighted::albedo_layer;

const GROUP = vec2(32, 8);
const STAGED_WIDTH = 34;
const STAGED = 34 * 10;
const INVOCATIONS = 64;

var<workgroup> staged_color: array<vec4<f32>, STAGED>;
@if(demodulates) var<workgroup> staged_albedo: array<vec4<f32>, STAGED>;

// The pixel left of and above those of the workgroup.
var<private> corner: vec2<i32>;

// Beyond the edge of a level of `size` pixels, pixels repeat.
fn stage(group: vec2<i32>, invocation: u32, size: vec2<i32>) {
    corner = group * GROUP - 1;
    for (var i = i32(invocation); i < STAGED; i += INVOCATIONS) {
        let at = corner + vec2(i % STAGED_WIDTH, i / STAGED_WIDTH);
        let pixel = finest(vec2<u32>(clamp(at, vec2(0), size - 1)));
        staged_color[i] = color_layer(pixel);
        @if(demodulates)
        staged_albedo[i] = albedo_layer(pixel);
    }
    workgroupBarrier();
}

fn staged(pixel: vec2<i32>) -> Pixel {
    let at = pixel - corner;
    let i = at.y * STAGED_WIDTH + at.x;
    @if(demodulates)
    return pixel_of(staged_color[i], staged_albedo[i]);
    @else
    return pixel_of(staged_color[i]);
}
