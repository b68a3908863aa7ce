// The surface's position in the last frame at each pixel's center, and its depth now. Uses only the
// center: at an edge, a mean of several samples would point to where neither surface was.

struct View {
    origin: vec3<f32>,       // of the camera
    right: vec3<f32>,        // from the center of the image plane to its edge
    up: vec3<f32>,
    forward: vec3<f32>,
}

// Keep in step with `GpuViews` in `motion.rs`.
struct Views {
    now: View,
    last: View,
    size: vec2<u32>,         // pixels
}

@group(1) @binding(0) var<uniform> views: Views;
@group(1) @binding(1) var vectors: texture_storage_2d<rg32float, write>;
@group(1) @binding(2) var depths: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn motion(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= views.size) {
        return;
    }
    let ray = center_ray(id.xy);
    let hit = trace(ray, FAR, false);
    // The background's direction does not depend on the camera's position.
    var from_last = ray.direction;
    var depth = 0.0;
    if hit.primitive != NOTHING {
        let way = hit.distance * ray.direction;
        from_last = ray.origin + way - primitives[hit.primitive].moved - views.last.origin;
        depth = dot(way, views.now.forward);
    }
    let vector = pixel_of(from_last, views.last) - center(id.xy);
    textureStore(vectors, id.xy, vec4(vector, 0.0, 0.0));
    textureStore(depths, id.xy, vec4(depth, 0.0, 0.0, 0.0));
}

fn center(pixel: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(pixel) + 0.5;
}

fn center_ray(pixel: vec2<u32>) -> Ray {
    let view = views.now;
    let at = 2.0 * center(pixel) / vec2<f32>(views.size) - 1.0;
    return Ray(view.origin, normalize(view.forward + at.x * view.right - at.y * view.up));
}

// The pixel position at which a camera sees this offset, from the top left corner.
fn pixel_of(offset: vec3<f32>, view: View) -> vec2<f32> {
    let size = vec2<f32>(views.size);
    let depth = dot(offset, view.forward);
    // What was behind the camera was outside the image.
    if depth <= 0.0 {
        return -2.0 * size;
    }
    let across = vec2(dot(offset, view.right), -dot(offset, view.up));
    let half_size = vec2(dot(view.right, view.right), dot(view.up, view.up));
    return (across / (half_size * depth) + 1.0) * 0.5 * size;
}
