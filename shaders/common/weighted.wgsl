// Pixels of a kernel pyramid: a color and its weight. As with premultiplied alpha, weighted colors
// add up. Weights and colors are kept apart, so that neither overflows and the mean of equal colors
// is that color, bit for bit. With demodulation a pixel also has an albedo of the same weight,
// stored in a second layer.

alias LightIn = texture_storage_2d_array<rgba32float, read>;
alias LightOut = texture_storage_2d_array<rgba32float, write>;

const MOST_LOGIT = 8.0;      // confidences and shares lie between exp(−8) and exp(8)
const LAST_QUAD = 2u;        // of the logits: the last tap, confidence and share

// Without demodulation the albedo is black and costs nothing.
struct Pixel {
    color: vec3<f32>,
    weight: f32,
    albedo: vec3<f32>,
}

// A pixel from its layers. Kernels load and store these themselves, because naga writes no Metal
// for functions with storage textures as parameters.
@if(demodulates)
fn pixel_of(color: vec4<f32>, albedo: vec4<f32>) -> Pixel {
    return Pixel(color.rgb, color.w, albedo.rgb);
}
@else
fn pixel_of(color: vec4<f32>) -> Pixel {
    return Pixel(color.rgb, color.w, vec3<f32>());
}

fn color_layer(pixel: Pixel) -> vec4<f32> {
    return vec4(pixel.color, pixel.weight);
}

@if(demodulates)
fn albedo_layer(pixel: Pixel) -> vec4<f32> {
    return vec4(pixel.albedo, 0.0);
}

fn weight_of(logit: f32) -> f32 {
    return exp(clamp(logit, -MOST_LOGIT, MOST_LOGIT));
}

fn confidence(logits: vec4<f32>) -> f32 {
    return weight_of(logits.y);
}

fn share(logits: vec4<f32>) -> f32 {
    return weight_of(logits.z);
}

// The reciprocal of a sum of weights; 0 if nothing has any weight. The reciprocal of a smaller sum
// could be infinite.
fn inverse(sum: f32) -> f32 {
    return select(0.0, 1.0 / sum, sum >= 1.1754944e-38);
}

fn mean_of_four(
    a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>, shares: vec4<f32>,
) -> vec3<f32> {
    let mean = mat4x3(a, b, c, d) * shares;
    return clamp(mean, min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
}

// The sum of four pixels, each times a factor.
fn sum_of_four(a: Pixel, b: Pixel, c: Pixel, d: Pixel, factors: vec4<f32>) -> Pixel {
    let weights = vec4(a.weight, b.weight, c.weight, d.weight) * factors;
    let sum = dot(weights, vec4(1.0));
    let shares = weights * inverse(sum);
    let color = mean_of_four(a.color, b.color, c.color, d.color, shares);
    @if(demodulates)
    let albedo = mean_of_four(a.albedo, b.albedo, c.albedo, d.albedo, shares);
    @else
    let albedo = vec3<f32>();
    return Pixel(color, sum, albedo);
}

fn mean_of_two(a: vec3<f32>, b: vec3<f32>, shares: vec2<f32>) -> vec3<f32> {
    // `mix` would take 1 − t for the share of `a`, which loses its digits where t is almost 1.
    return clamp(a * shares.x + b * shares.y, min(a, b), max(a, b));
}

// The sum of two pixels, the second times a factor.
fn sum_of_two(a: Pixel, b: Pixel, factor: f32) -> Pixel {
    let weights = vec2(a.weight, b.weight * factor);
    let sum = weights.x + weights.y;
    let shares = weights * inverse(sum);
    let color = mean_of_two(a.color, b.color, shares);
    @if(demodulates)
    let albedo = mean_of_two(a.albedo, b.albedo, shares);
    @else
    let albedo = vec3<f32>();
    return Pixel(color, sum, albedo);
}
