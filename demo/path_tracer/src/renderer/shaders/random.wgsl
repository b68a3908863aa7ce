// Random numbers: the PCG hash of Jarzynski and Olano, "Hash Functions for GPU Rendering",
// JCGT 9(3), 2020. Every sample of every pixel has its own sequence.

var<private> random_state: u32;

fn pcg(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn seed_random(pixel: u32, sample: u32, seed: u32) {
    random_state = pcg(pixel + pcg(sample + pcg(seed)));
}

// Uniform in [0, 1).
fn random() -> f32 {
    random_state = random_state * 747796405u + 2891336453u;
    let word = ((random_state >> ((random_state >> 28u) + 4u)) ^ random_state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) * 0x1p-24;
}

fn random_pair() -> vec2<f32> {
    let first = random();
    return vec2(first, random());
}
