// What colour is multiplied by for the network.

@group(0) @binding(4) var<storage, read> input_scale: f32;
