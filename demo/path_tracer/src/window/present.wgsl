// Shows linear color on the screen: noisy left of the divider, denoised right of it.

struct Screen {
    divider: f32,            // pixels from the left edge
    exposure: f32,           // factor on color
    encode: u32,             // 1: encode sRGB here, since the surface does not
    divided: u32,            // 1: draw the divider
}

@group(0) @binding(0) var<uniform> screen: Screen;
@group(0) @binding(1) var noisy: texture_2d<f32>;
@group(0) @binding(2) var denoised: texture_2d<f32>;

// One triangle that covers the screen.
@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn present(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    var color = textureLoad(denoised, pixel, 0).rgb;
    if position.x < screen.divider {
        color = textureLoad(noisy, pixel, 0).rgb;
    }
    if screen.divided == 1u && abs(position.x - screen.divider) < 1.0 {
        color = vec3(1.0) / screen.exposure;
    }
    let display = tone_map(color * screen.exposure);
    return vec4(select(display, srgb(display), screen.encode == 1u), 1.0);
}

// Narkowicz's fit of the ACES filmic curve, 2015; the caller sets the exposure.
fn tone_map(color: vec3<f32>) -> vec3<f32> {
    let up = color * (2.51 * color + 0.03);
    let down = color * (2.43 * color + 0.59) + 0.14;
    return clamp(up / down, vec3(0.0), vec3(1.0));
}

// IEC 61966-2-1.
fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3(0.0031308));
}
