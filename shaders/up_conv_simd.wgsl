// What the generated start of a decoder level for CPU drivers reads.

import package::common::tensor::TensorIn;

@group(0) @binding(0) var skip: TensorIn;
@group(0) @binding(6) var low: TensorIn;
