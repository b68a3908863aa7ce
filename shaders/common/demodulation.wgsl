// Demodulation: light is divided by its texture before it is gathered and multiplied by it after,
// so that gathering blurs the noise but not the texture. The texture is the albedo's contrast
// (contrast.wgsl) to the power that the network predicts. Without the feature, light stays as it is.

@if(demodulates) import package::common::weighted::MOST_LOGIT;

// Sampled, since few storage textures fit into a kernel. Always the last binding.
@if(demodulates && gather && stored_finest) @group(0) @binding(9) var contrast: texture_2d<f32>;
@elif(demodulates && gather) @group(0) @binding(8) var contrast: texture_2d<f32>;
@elif(demodulates && level0 && !layer) @group(0) @binding(5) var contrast: texture_2d<f32>;
@elif(demodulates) @group(0) @binding(6) var contrast: texture_2d<f32>;

@if(demodulates) const GAIN = 8.0;   // of the logit of the power

// `logits` are the last quad of the pixel's.
@if(demodulates)
fn demodulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    return light * texture_to(-1.0, pixel, logits);
}
@else
fn demodulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    return light;
}

@if(demodulates)
fn modulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    return light * texture_to(1.0, pixel, logits);
}
@else
fn modulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    return light;
}

// The texture, or its reciprocal if `sign` is −1: at most 21. Exactly 1 without contrast.
@if(demodulates)
fn texture_to(sign: f32, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    let contrast_here = textureLoad(contrast, pixel, 0).rgb;
    // Beyond the limits the power is 0 or 1, and the exponential would be infinite.
    let power = 1.0 / (1.0 + exp(-GAIN * clamp(logits.w, -MOST_LOGIT, MOST_LOGIT)));
    return select(exp(sign * power * contrast_here), vec3(1.0), contrast_here == vec3(0.0));
}
