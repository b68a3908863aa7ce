// What the generated 3×3 convolution for CPU drivers reads.

import package::common::tensor::TensorIn;

@group(0) @binding(0) var input: TensorIn;
