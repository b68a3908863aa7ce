// The scene's buffers; keep every struct in step with `scene_buffers.rs` and `bvh.rs`.

const SPHERE = 0u;           // `at`: center, `edge1.x`: radius
const QUAD = 1u;             // `at`: a corner, with the edges that leave it
const TRIANGLE = 2u;         // the same, with a normal at each corner

struct Primitive {
    at: vec3<f32>,
    kind: u32,
    edge1: vec3<f32>,
    material: u32,
    edge2: vec3<f32>,
    moved: vec3<f32>,        // since the last frame, in meters
    normals: array<vec3<f32>, 3>,
}

const DIFFUSE = 0u;
const METAL = 1u;
const GLASS = 2u;
const EMITTER = 3u;

struct Material {
    color: vec3<f32>,        // reflectance, or an emitter's radiance
    kind: u32,
    second_color: vec3<f32>, // of every other cell
    cell: f32,               // side of a checkerboard cell in meters; 0: one color
    alpha: f32,              // GGX width
    ior: f32,                // index of refraction
}

struct Node {
    low: vec3<f32>,
    next: u32,               // inner: the node after its descendants; leaf: its first primitive
    high: vec3<f32>,
    count: u32,              // primitives in a leaf; 0 for an inner node
}

struct World {
    horizon: vec3<f32>,      // radiance of the sky at the horizon
    lights: u32,             // number of sampled lights
    zenith: vec3<f32>,       // radiance of the sky at the zenith
    sun_cosine: f32,         // of the sun's angular radius
    sun_direction: vec3<f32>,
    sun_radiance: vec3<f32>,
}

@group(0) @binding(0) var<storage, read> nodes: array<Node>;
@group(0) @binding(1) var<storage, read> primitives: array<Primitive>;
@group(0) @binding(2) var<uniform> world: World;
@group(0) @binding(3) var<storage, read> materials: array<Material>;
// Indices of the emitting primitives, and `SUN`.
@group(0) @binding(4) var<storage, read> lights: array<u32>;
