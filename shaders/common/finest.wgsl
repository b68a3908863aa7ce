// The finest level of a kernel pyramid: the noisy color with its confidence as the weight.

import package::common::place::place;
import package::common::repair::repaired;
import package::common::tensor::TensorIn;
import package::common::weighted::{LAST_QUAD, confidence};

@if(gather) @group(0) @binding(6) var finest_logits: TensorIn;
@else @group(0) @binding(5) var finest_logits: TensorIn;

fn finest(pixel: vec2<u32>) -> vec4<f32> {
    let color = repaired(place(pixel));
    return vec4(color.rgb, color.w * confidence(textureLoad(finest_logits, pixel, LAST_QUAD)));
}
