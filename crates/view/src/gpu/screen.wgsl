// Draws one or two images into the image area of the window.

struct View {
    // Size of the area, in pixels.
    area: vec2f,
    // Image position at the center of the area, or of each half.
    center: vec2f,
    // Size of the image, in pixels.
    size: vec2f,
    // Kinds of the left and the right image.
    kinds: vec2u,
    // Screen pixels per image pixel.
    zoom: f32,
    // Factor on light.
    gain: f32,
    // Factor on a difference.
    amplification: f32,
    // Column of the line between two images.
    split: f32,
    // Tone curve: 0 is sRGB, 1 is filmic.
    curve: u32,
    // Whether each half shows the whole view rather than its own part of it.
    halves: u32,
    // Whether the target encodes linear values itself.
    encodes: u32,
    padding: u32,
}

const LIGHT = 0u;
const SURFACE = 1u;
const DIRECTION = 2u;
const DIFFERENCE = 3u;

const BACKGROUND = vec3f(0.011);
// No renderer produces this color, so broken pixels stand out.
const BROKEN = vec3f(1.0, 0.0, 1.0);

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var left: texture_2d<f32>;
@group(0) @binding(2) var right: texture_2d<f32>;
// The image that a difference subtracts.
@group(0) @binding(3) var subtracted: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

// One triangle that covers the area.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0), uv);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    // The pixel's center. Interpolated positions are less exact and would give ragged edges.
    var place = floor(corner.uv * view.area) + 0.5;
    var area = view.area;
    let is_right = place.x >= view.split;
    if view.halves != 0u {
        area.x = view.split;
        place.x -= select(0.0, view.split, is_right);
    }
    let at = view.center + (place - 0.5 * area) / view.zoom;
    if any(at < vec2f(0.0)) || any(at >= view.size) {
        return vec4f(shown(BACKGROUND), 1.0);
    }
    var color = vec4f();
    if is_right {
        color = looked_up(right, at);
    } else {
        color = looked_up(left, at);
    }
    let kind = select(view.kinds.x, view.kinds.y, is_right);
    return vec4f(colored(kind, color, at), 1.0);
}

// Samples an image: nearest when magnified twice or more or at 1:1, otherwise bilinear.
fn looked_up(image: texture_2d<f32>, at: vec2f) -> vec4f {
    if view.zoom >= 2.0 || view.zoom == 1.0 {
        return textureLoad(image, vec2i(at), 0);
    }
    let wanted = i32(floor(log2(max(1.0 / view.zoom, 1.0))));
    let level = min(wanted, i32(textureNumLevels(image)) - 1);
    let last = vec2i(textureDimensions(image, level)) - 1;
    let place = at / vec2f(f32(1u << u32(level))) - 0.5;
    let first = vec2i(floor(place));
    let part = place - floor(place);
    let texel = array(
        textureLoad(image, clamp(first, vec2i(0), last), level),
        textureLoad(image, clamp(first + vec2i(1, 0), vec2i(0), last), level),
        textureLoad(image, clamp(first + vec2i(0, 1), vec2i(0), last), level),
        textureLoad(image, clamp(first + vec2i(1, 1), vec2i(0), last), level),
    );
    return mix(mix(texel[0], texel[1], part.x), mix(texel[2], texel[3], part.x), part.y);
}

fn colored(kind: u32, value: vec4f, at: vec2f) -> vec3f {
    if value.a > 0.0 && kind != DIFFERENCE {
        return shown(mix(value.rgb, BROKEN, value.a));
    }
    switch kind {
        case SURFACE: { return shown(value.rgb); }
        case DIRECTION: { return direct(0.5 * value.rgb + 0.5); }
        case DIFFERENCE: {
            let apart = abs(value.rgb - looked_up(subtracted, at).rgb);
            return shown(apart * view.gain * view.amplification);
        }
        default: { return toned(max(value.rgb, vec3f(0.0)) * view.gain); }
    }
}

fn toned(light: vec3f) -> vec3f {
    if view.curve == 0u {
        return shown(light);
    }
    // Krzysztof Narkowicz, "ACES Filmic Tone Mapping Curve", 2016.
    let x = min(light, vec3f(1e4));
    return shown(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
}

// Converts linear light to what the target expects.
fn shown(light: vec3f) -> vec3f {
    let v = clamp(light, vec3f(0.0), vec3f(1.0));
    if view.encodes != 0u {
        return v;
    }
    return select(1.055 * pow(v, vec3f(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3f(0.0031308));
}

// Converts screen values to what the target expects.
fn direct(value: vec3f) -> vec3f {
    if view.encodes == 0u {
        return value;
    }
    return select(pow((value + 0.055) / 1.055, vec3f(2.4)), value / 12.92, value <= vec3f(0.04045));
}
