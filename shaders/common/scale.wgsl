// The factor for the color that the network reads.

@group(0) @binding(4) var<storage, read> input_scale: f32;
