// Uniforms of one dispatch; keep in step with `GpuFrame` in `film.rs`.

struct Frame {
    origin: vec3<f32>,       // of the camera
    first_sample: u32,       // samples already in the sums
    right: vec3<f32>,        // from the center of the image plane to its edge
    samples: u32,            // to add
    up: vec3<f32>,
    seed: u32,
    forward: vec3<f32>,
    size: vec2<u32>,         // pixels
}
