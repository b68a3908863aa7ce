// One level of a kernel pyramid: the sum of 2×2 pixels of the finer level, a quarter each, times
// the level's confidence. One pixel per invocation. The finest level is the noisy color times its
// confidence; it is not stored, so the second level computes it.

import package::common::tensor::TensorIn;
import package::common::weighted::{LAST_QUAD, LightOut, confidence, sum_of_four};
@if(finest) import package::common::finest::finest;
@else import package::common::weighted::LightIn;

@if(finest) @group(0) @binding(2) var logits: TensorIn;
@else @group(0) @binding(1) var logits: TensorIn;

@if(finest) @group(0) @binding(3) var output: LightOut;
@else @group(0) @binding(2) var output: LightOut;

@if(!finest) @group(0) @binding(0) var input: LightIn;

fn finer(pixel: vec2<u32>) -> vec4<f32> {
    @if(finest)
    return finest(pixel);
    @else
    return textureLoad(input, pixel, 0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(output)) {
        return;
    }
    let corner = id.xy * 2u;
    let sum = sum_of_four(
        finer(corner),
        finer(corner + vec2(1u, 0u)),
        finer(corner + vec2(0u, 1u)),
        finer(corner + vec2(1u, 1u)),
        vec4(0.25),
    );
    let own = confidence(textureLoad(logits, id.xy, LAST_QUAD));
    textureStore(output, id.xy, 0, vec4(sum.rgb, sum.w * own));
}
