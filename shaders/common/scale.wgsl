// The factor that brings color to the network's exposure.

@group(0) @binding(4) var<storage, read> input_scale: f32;
