// Light from emitters, the sun and the sky, by light sampling and by scattering, combined with the
// power heuristic (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997).

const SUN = 0xffffffffu;

struct LightSample {
    direction: vec3<f32>,
    distance: f32,
    radiance: vec3<f32>,
    density: f32,            // per steradian; 0: no light from this direction
}

// Reflected light from one randomly chosen light.
fn direct_light(surface: Surface, out: vec3<f32>) -> vec3<f32> {
    if world.lights == 0u || surface.material.kind == GLASS {
        return vec3(0.0);
    }
    let light = sample_light(surface.position);
    let value = bsdf(surface, out, light.direction);
    if value.w == 0.0 || light.density == 0.0 {
        return vec3(0.0);
    }
    let shadow_ray = leave(surface, light.direction);
    if trace(shadow_ray, light.distance * 0.999, true).primitive != NOTHING {
        return vec3(0.0);
    }
    return heuristic(light.density, value.w) / light.density * value.rgb * light.radiance;
}

fn heuristic(taken: f32, other: f32) -> f32 {
    let ratio = other / taken;
    return 1.0 / (1.0 + ratio * ratio);
}

// The weight of light found by scattering; 1 where light sampling cannot find it.
fn chance_weight(scattering: f32, light: f32) -> f32 {
    if scattering == 0.0 || world.lights == 0u {
        return 1.0;
    }
    return heuristic(scattering, light / f32(world.lights));
}

fn sample_light(origin: vec3<f32>) -> LightSample {
    let choice = min(u32(random() * f32(world.lights)), world.lights - 1u);
    var light: LightSample;
    if lights[choice] == SUN {
        let height = 1.0 - world.sun_cosine;
        let direction = frame_around(world.sun_direction) * cone_direction(height);
        light = LightSample(direction, FAR, world.sun_radiance, cone_density(height));
    } else if primitives[lights[choice]].kind == SPHERE {
        light = sample_sphere(origin, primitives[lights[choice]]);
    } else {
        light = sample_face(origin, primitives[lights[choice]]);
    }
    light.density /= f32(world.lights);
    return light;
}

fn sample_face(origin: vec3<f32>, face: Primitive) -> LightSample {
    var uv = random_pair();
    if face.kind == TRIANGLE && uv.x + uv.y > 1.0 {
        uv = 1.0 - uv;
    }
    let to_light = face.at + uv.x * face.edge1 + uv.y * face.edge2 - origin;
    let distance = length(to_light);
    let direction = to_light / distance;
    let density = face_density(face, direction, distance);
    return LightSample(direction, distance, materials[face.material].color, density);
}

// Density of points uniform over the area; 0 from behind, where the face emits nothing.
fn face_density(face: Primitive, direction: vec3<f32>, distance: f32) -> f32 {
    let across = cross(face.edge1, face.edge2);
    let area = select(1.0, 0.5, face.kind == TRIANGLE) * length(across);
    let cosine = -dot(normalize(across), direction);
    return select(0.0, distance * distance / (cosine * area), cosine > 0.0);
}

// Directions uniform over the cone that the sphere subtends.
fn sample_sphere(origin: vec3<f32>, sphere: Primitive) -> LightSample {
    let to_center = sphere.at - origin;
    let height = sphere_cone(sphere, to_center);
    let direction = frame_around(normalize(to_center)) * cone_direction(height);
    let distance = hit_sphere(Ray(origin, direction), sphere.at, sphere.edge1.x);
    // Rounding may make a ray along the cone's edge miss; it then ends beside the center.
    let reach = select(dot(to_center, direction), distance, distance > 0.0);
    return LightSample(direction, reach, materials[sphere.material].color, cone_density(height));
}

// 1 − cosine of the sphere's angular radius, without cancellation.
fn sphere_cone(sphere: Primitive, to_center: vec3<f32>) -> f32 {
    let sine2 = min(sphere.edge1.x * sphere.edge1.x / dot(to_center, to_center), 1.0);
    return sine2 / (1.0 + sqrt(1.0 - sine2));
}

fn cone_direction(height: f32) -> vec3<f32> {
    let xi = random_pair();
    let below = xi.x * height;
    let radius = sqrt(below * (2.0 - below));
    let angle = 2.0 * PI * xi.y;
    return vec3(radius * cos(angle), radius * sin(angle), 1.0 - below);
}

fn cone_density(height: f32) -> f32 {
    return 1.0 / (2.0 * PI * height);
}

// Light of an emitter that a scattered ray hit; `density` is the scattering's.
fn emitted(ray: Ray, hit: Hit, surface: Surface, density: f32) -> vec3<f32> {
    if !surface.outward {
        return vec3(0.0);
    }
    let primitive = primitives[surface.primitive];
    var light = face_density(primitive, ray.direction, hit.distance);
    if primitive.kind == SPHERE {
        light = cone_density(sphere_cone(primitive, primitive.at - ray.origin));
    }
    return chance_weight(density, light) * surface.material.color;
}

// The sky's gradient, plus the sun where the ray hits it.
fn sky(direction: vec3<f32>, density: f32) -> vec3<f32> {
    let gradient = mix(world.horizon, world.zenith, sqrt(max(direction.y, 0.0)));
    if dot(direction, world.sun_direction) < world.sun_cosine {
        return gradient;
    }
    let weight = chance_weight(density, cone_density(1.0 - world.sun_cosine));
    return gradient + weight * world.sun_radiance;
}
