// What one dispatch draws, as `film.rs` lays it out.

struct Frame {
    origin: vec3<f32>,       // of the camera
    first_sample: u32,       // samples that the sums hold already
    right: vec3<f32>,        // from the middle of the image plane to its edge
    samples: u32,            // to add
    up: vec3<f32>,
    seed: u32,
    forward: vec3<f32>,
    size: vec2<u32>,         // pixels
}
