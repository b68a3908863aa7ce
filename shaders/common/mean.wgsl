// The mean of a frame, with weight 1, and the last frames.

import package::common::light::is_finite;

// w holds how many of the last frames count: none if the mean is not a number.
fn mean_with(past: vec3<f32>, frames: f32, frame: vec3<f32>) -> vec4<f32> {
    let mean = frame + frames / (1.0 + frames) * (past - frame);
    let is_mean = frames > 0.0 && is_finite(bitcast<vec3<u32>>(mean));
    return select(vec4(frame, 0.0), vec4(mean, frames), is_mean);
}
