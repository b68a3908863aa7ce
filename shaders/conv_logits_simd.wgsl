// The last 3×3 convolution of a kernel pyramid and the 1×1 convolution to its logits, for CPU
// drivers: what the generated code reads.

import package::common::tensor::TensorIn;

@group(0) @binding(0) var input: TensorIn;
// Layer = quad of logits, row = quad of the 3×3 convolution, texel = channel within it: what that
// channel adds to four logits.
@group(0) @binding(6) var logits_weights: texture_storage_2d_array<rgba32float, read>;
