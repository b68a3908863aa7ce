// The last 3×3 convolution of a kernel pyramid and the 1×1 convolution to its logits, for CPU
// drivers: the weights of the 1×1 convolution.

// Layer = quad of logits, row = quad of the 3×3 convolution, texel = channel within it: what that
// channel adds to four logits.
@group(0) @binding(6) var logits_weights: texture_storage_2d_array<rgba32float, read>;
