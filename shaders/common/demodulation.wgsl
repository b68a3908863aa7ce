// Demodulation: the weights that gather light also gather the albedo, and gathered light is
// multiplied by the ratio of the pixel's own albedo to the gathered one, to the power that the
// network predicts. So gathering blurs the noise but not the texture. Without the feature, light
// stays as it is.

@if(demodulates) import package::common::weighted::MOST_LOGIT;

// Sampled, since a kernel can bind only few storage textures. Always the last binding.
@if(demodulates && stored_finest) @group(0) @binding(9) var contrast: texture_2d<f32>;
@elif(demodulates) @group(0) @binding(8) var contrast: texture_2d<f32>;

@if(stores_contrast) const FLOOR = 0.05;    // added to the albedo: noise in black is not texture
@if(demodulates) const GAIN = 8.0;   // of the logit of the power

// The logarithm of the ratio of a pixel's albedo to the gathered one. Exactly 0 where they are
// equal, and where nothing has any weight.
@if(stores_contrast)
fn contrast_of(own: vec3<f32>, gathered: vec4<f32>) -> vec3<f32> {
    let contrast = log((own + FLOOR) / (gathered.rgb + FLOOR));
    return select(contrast, vec3(0.0), (own == gathered.rgb) | vec3(gathered.w == 0.0));
}

// `logits` is the last quad of the pixel's logits. The factor is at most 21, and exactly 1 without
// contrast.
@if(demodulates)
fn modulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    let contrast_here = textureLoad(contrast, pixel, 0).rgb;
    // Beyond the limits the power is 0 or 1, and the exponential could be infinite.
    let power = 1.0 / (1.0 + exp(-GAIN * clamp(logits.w, -MOST_LOGIT, MOST_LOGIT)));
    return light * select(exp(power * contrast_here), vec3(1.0), contrast_here == vec3(0.0));
}
@else
fn modulated(light: vec3<f32>, pixel: vec2<u32>, logits: vec4<f32>) -> vec3<f32> {
    return light;
}
