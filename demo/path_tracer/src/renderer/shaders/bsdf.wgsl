// How materials scatter light. Directions point away from the surface; local z is the normal.

const PI = 3.14159265;

struct Scattered {
    direction: vec3<f32>,
    weight: vec3<f32>,       // BSDF · cosine ÷ density; 0: absorbed
    density: f32,            // per steradian; 0: a delta distribution
}

// BSDF · cosine in rgb, the density of `scatter` in w; 0 for glass, which scatters into deltas.
fn bsdf(surface: Surface, out: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let frame = frame_around(surface.normal);
    let local = direction * frame;
    if local.z <= 0.0 || dot(direction, surface.geometric) <= 0.0 {
        return vec4(0.0);
    }
    switch surface.material.kind {
        case DIFFUSE: { return vec4(surface.material.color, 1.0) * local.z / PI; }
        case METAL: { return metal(surface.material, out * frame, local); }
        default: { return vec4(0.0); }
    }
}

fn scatter(surface: Surface, out: vec3<f32>) -> Scattered {
    if surface.material.kind == GLASS {
        return scatter_glass(surface, out);
    }
    let frame = frame_around(surface.normal);
    var local = cosine_direction();
    if surface.material.kind == METAL {
        let view = out * frame;
        local = reflect(-view, visible_normal(view, surface.material.alpha));
    }
    let direction = frame * local;
    let value = bsdf(surface, out, direction);
    return Scattered(direction, select(vec3(0.0), value.rgb / value.w, value.w > 0.0), value.w);
}

// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
fn frame_around(n: vec3<f32>) -> mat3x3<f32> {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    let x = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    let y = vec3(b, s + n.y * n.y * a, -n.y);
    return mat3x3(x, y, n);
}

fn cosine_direction() -> vec3<f32> {
    let xi = random_pair();
    let radius = sqrt(xi.x);
    let angle = 2.0 * PI * xi.y;
    return vec3(radius * cos(angle), radius * sin(angle), sqrt(1.0 - xi.x));
}

// GGX with the height-correlated Smith term (Heitz, "Understanding the Masking-Shadowing
// Function", JCGT 3(2), 2014) and Schlick's Fresnel term.
fn metal(material: Material, out: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let half_way = normalize(out + direction);
    let stretched = vec3(half_way.xy / material.alpha, half_way.z);
    let steep = dot(stretched, stretched);
    let facets = 1.0 / (PI * material.alpha * material.alpha * steep * steep);
    let hidden_out = smith_lambda(out, material.alpha);
    let hidden = hidden_out + smith_lambda(direction, material.alpha);
    let fresnel = mix(material.color, vec3(1.0), pow(max(1.0 - dot(out, half_way), 0.0), 5.0));
    let common_part = facets / (4.0 * out.z);
    return common_part * vec4(fresnel / (1.0 + hidden), 1.0 / (1.0 + hidden_out));
}

fn smith_lambda(direction: vec3<f32>, alpha: f32) -> f32 {
    let tangent = alpha * length(direction.xy) / direction.z;
    return (sqrt(1.0 + tangent * tangent) - 1.0) / 2.0;
}

// Samples a microfacet normal by visible area (Dupuy and Benyoub, "Sampling Visible GGX Normals
// with Spherical Caps", 2023).
fn visible_normal(out: vec3<f32>, alpha: f32) -> vec3<f32> {
    let xi = random_pair();
    let view = normalize(vec3(alpha * out.xy, out.z));
    let z = (1.0 - xi.x) * (1.0 + view.z) - view.z;
    let radius = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    let angle = 2.0 * PI * xi.y;
    let half_way = vec3(radius * cos(angle), radius * sin(angle), z) + view;
    return normalize(vec3(alpha * half_way.xy, half_way.z));
}

// Smooth glass reflects or refracts. Refraction also scales radiance, but light that enters also
// leaves before it reaches the camera, so the factors cancel.
fn scatter_glass(surface: Surface, out: vec3<f32>) -> Scattered {
    let ior = surface.material.ior;
    let eta = select(ior, 1.0 / ior, surface.outward);
    let cosine = dot(out, surface.normal);
    let refracted = refract(-out, surface.normal, eta);
    if random() < fresnel_of_glass(cosine, eta) {
        return Scattered(reflect(-out, surface.normal), vec3(1.0), 0.0);
    }
    return Scattered(refracted, surface.material.color, 0.0);
}

// Reflectance for unpolarized light; `eta` is the index of refraction outside over that inside.
fn fresnel_of_glass(cosine: f32, eta: f32) -> f32 {
    let sine2 = eta * eta * (1.0 - cosine * cosine);
    if sine2 >= 1.0 {
        return 1.0;
    }
    let inside = sqrt(1.0 - sine2);
    let parallel = (cosine - eta * inside) / (cosine + eta * inside);
    let across = (eta * cosine - inside) / (eta * cosine + inside);
    return (parallel * parallel + across * across) / 2.0;
}
