// The surface at a ray's hit.

struct Surface {
    position: vec3<f32>,
    geometric: vec3<f32>,    // unit normal of the shape, towards the ray
    normal: vec3<f32>,       // unit shading normal, towards the ray
    outward: bool,           // the ray hit the outside
    primitive: u32,
    material: Material,
}

fn surface_at(ray: Ray, hit: Hit) -> Surface {
    let primitive = primitives[hit.primitive];
    let outside = outside_normal(primitive, ray.origin + hit.distance * ray.direction);
    let outward = dot(outside, ray.direction) < 0.0;
    let geometric = select(-outside, outside, outward);
    var surface: Surface;
    surface.position = position_on(primitive, hit, outside);
    surface.geometric = geometric;
    surface.normal = shading_normal(primitive, hit.uv, geometric, ray.direction);
    surface.outward = outward;
    surface.primitive = hit.primitive;
    surface.material = materials[primitive.material];
    surface.material.color = color_at(surface.material, surface.position);
    return surface;
}

fn outside_normal(primitive: Primitive, position: vec3<f32>) -> vec3<f32> {
    if primitive.kind == SPHERE {
        return normalize(position - primitive.at);
    }
    return normalize(cross(primitive.edge1, primitive.edge2));
}

// More precise than a point computed along a long ray.
fn position_on(primitive: Primitive, hit: Hit, outside: vec3<f32>) -> vec3<f32> {
    if primitive.kind == SPHERE {
        return primitive.at + primitive.edge1.x * outside;
    }
    return primitive.at + hit.uv.x * primitive.edge1 + hit.uv.y * primitive.edge2;
}

// Interpolated over a triangle, unless the result faces away from the ray.
fn shading_normal(
    primitive: Primitive, uv: vec2<f32>, geometric: vec3<f32>, direction: vec3<f32>,
) -> vec3<f32> {
    if primitive.kind != TRIANGLE {
        return geometric;
    }
    let n = primitive.normals;
    let blend = normalize((1.0 - uv.x - uv.y) * n[0] + uv.x * n[1] + uv.y * n[2]);
    let normal = select(-blend, blend, dot(blend, geometric) > 0.0);
    return select(geometric, normal, dot(normal, direction) < 0.0);
}

fn color_at(material: Material, position: vec3<f32>) -> vec3<f32> {
    if material.cell == 0.0 {
        return material.color;
    }
    // Cells are centered on the origin, so no coordinate plane runs along their edges.
    let cell = vec3<i32>(floor(position / material.cell + 0.5));
    return select(material.color, material.second_color, ((cell.x + cell.y + cell.z) & 1) == 1);
}

// A ray that leaves the surface, offset by more than rounding so that it does not hit it again.
fn leave(surface: Surface, direction: vec3<f32>) -> Ray {
    let size = max(max(abs(surface.position.x), abs(surface.position.y)), abs(surface.position.z));
    let off = 2e-5 * max(size, 1.0) * sign(dot(direction, surface.geometric));
    return Ray(surface.position + off * surface.geometric, direction);
}
