// Adds samples of color, albedo and normal to every pixel's sums.

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> colors: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read_write> albedos: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> normals: array<vec4<f32>>;

struct Sample {
    color: vec4<f32>,        // alpha: 1 where there is a surface
    albedo: vec3<f32>,
    normal: vec3<f32>,
}

@compute @workgroup_size(8, 8)
fn path_trace(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    var sum = Sample(vec4(0.0), vec3(0.0), vec3(0.0));
    if frame.first_sample > 0u {
        sum = Sample(colors[pixel], albedos[pixel].xyz, normals[pixel].xyz);
    }
    for (var i = 0u; i < frame.samples; i++) {
        seed_random(pixel, frame.first_sample + i, frame.seed);
        let found = follow_path(camera_ray(id.xy));
        sum = Sample(sum.color + found.color, sum.albedo + found.albedo, sum.normal + found.normal);
    }
    colors[pixel] = sum.color;
    albedos[pixel] = vec4(sum.albedo, 0.0);
    normals[pixel] = vec4(sum.normal, 0.0);
}

// A ray through a random point of the pixel. This box filter keeps noise independent per pixel.
fn camera_ray(pixel: vec2<u32>) -> Ray {
    let at = 2.0 * (vec2<f32>(pixel) + random_pair()) / vec2<f32>(frame.size) - 1.0;
    return Ray(frame.origin, normalize(frame.forward + at.x * frame.right - at.y * frame.up));
}

const MAX_SCATTERINGS = 32;  // longer paths are cut off
const SAFE_SCATTERINGS = 3;  // before Russian roulette begins

fn follow_path(camera: Ray) -> Sample {
    var ray = camera;
    var found = Sample(vec4(0.0), vec3(0.0), vec3(0.0));
    var throughput = vec3(1.0);
    var density = 0.0;
    for (var i = 0; i <= MAX_SCATTERINGS; i++) {
        let hit = trace(ray, FAR, false);
        if hit.primitive == NOTHING {
            found.color += vec4(throughput * sky(ray.direction, density), 0.0);
            break;
        }
        let surface = surface_at(ray, hit);
        if i == 0 {
            found = Sample(vec4(0.0, 0.0, 0.0, 1.0), albedo(surface.material), surface.normal);
        }
        if surface.material.kind == EMITTER {
            found.color += vec4(throughput * emitted(ray, hit, surface, density), 0.0);
            break;
        }
        let direct = direct_light(surface, -ray.direction);
        found.color += vec4(throughput * direct, 0.0);
        let next = scatter(surface, -ray.direction);
        throughput *= next.weight * roulette(throughput * next.weight, i);
        if all(throughput == vec3(0.0)) {
            break;
        }
        density = next.density;
        ray = leave(surface, next.direction);
    }
    return found;
}

// Ends dim paths at random and reweights the others, without bias.
fn roulette(throughput: vec3<f32>, scatterings: i32) -> f32 {
    if scatterings < SAFE_SCATTERINGS {
        return 1.0;
    }
    let survival = clamp(max(throughput.r, max(throughput.g, throughput.b)), 0.05, 1.0);
    return select(0.0, 1.0 / survival, random() < survival);
}

// Albedo as denoisers expect it: reflectance, 1 for clear glass, at most 1 for emitters.
fn albedo(material: Material) -> vec3<f32> {
    return min(material.color, vec3(1.0));
}
