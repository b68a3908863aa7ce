// Intersects rays with the scene.

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,    // unit length
}

struct Hit {
    distance: f32,           // in meters
    primitive: u32,
    uv: vec2<f32>,           // along the edges of a quad or triangle
}

const NOTHING = 0xffffffffu;
const FAR = 1e30;

// The nearest hit before `limit`, or with `any` the first one found, for shadow rays.
fn trace(ray: Ray, limit: f32, any: bool) -> Hit {
    var hit = Hit(limit, NOTHING, vec2(0.0));
    let inverse = 1.0 / away_from_zero(ray.direction);
    var index = 0u;
    while index < arrayLength(&nodes) {
        let node = nodes[index];
        let met = meets_box(ray.origin, inverse, node, hit.distance);
        if met && node.count > 0u {
            hit_leaf(ray, node, &hit);
            if any && hit.primitive != NOTHING {
                break;
            }
        }
        // In depth-first order, the first child, or the node after a leaf, is the next node.
        index = select(node.next, index + 1u, met || node.count > 0u);
    }
    return hit;
}

// A ray along an axis would give 0 / 0 on a box's planes.
fn away_from_zero(direction: vec3<f32>) -> vec3<f32> {
    return select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
}

fn meets_box(origin: vec3<f32>, inverse: vec3<f32>, node: Node, limit: f32) -> bool {
    let a = (node.low - origin) * inverse;
    let b = (node.high - origin) * inverse;
    let enter = min(a, b);
    let leave = max(a, b);
    let first = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let last = min(min(leave.x, leave.y), min(leave.z, limit));
    return first <= last;
}

fn hit_leaf(ray: Ray, leaf: Node, hit: ptr<function, Hit>) {
    for (var i = leaf.next; i < leaf.next + leaf.count; i++) {
        let found = hit_primitive(ray, primitives[i]);
        if found.x > 0.0 && found.x < (*hit).distance {
            *hit = Hit(found.x, i, found.yz);
        }
    }
}

// Distance and coordinates on the primitive; distance 0 is a miss.
fn hit_primitive(ray: Ray, primitive: Primitive) -> vec3<f32> {
    if primitive.kind == SPHERE {
        return vec3(hit_sphere(ray, primitive.at, primitive.edge1.x), 0.0, 0.0);
    }
    return hit_face(ray, primitive);
}

// Hearn and Baker's form computes the discriminant from the distance between center and ray, which
// stays precise far from small spheres ("Ray Tracing Gems", chapter 7).
fn hit_sphere(ray: Ray, center: vec3<f32>, radius: f32) -> f32 {
    let to_center = center - ray.origin;
    let along = dot(to_center, ray.direction);
    let aside = to_center - along * ray.direction;
    let discriminant = radius * radius - dot(aside, aside);
    if discriminant < 0.0 {
        return 0.0;
    }
    let half_chord = sqrt(discriminant);
    return select(along + half_chord, along - half_chord, along > half_chord);
}

// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
fn hit_face(ray: Ray, face: Primitive) -> vec3<f32> {
    let p = cross(ray.direction, face.edge2);
    let determinant = dot(face.edge1, p);
    if determinant == 0.0 {
        return vec3(0.0);
    }
    let from_corner = ray.origin - face.at;
    let q = cross(from_corner, face.edge1);
    let uv = vec2(dot(from_corner, p), dot(ray.direction, q)) / determinant;
    let reach = select(max(uv.x, uv.y), uv.x + uv.y, face.kind == TRIANGLE);
    let inside = min(uv.x, uv.y) >= 0.0 && reach <= 1.0;
    return select(vec3(0.0), vec3(dot(face.edge2, q) / determinant, uv), inside);
}
