// The input of the generated convolutions for CPU drivers.

import package::common::tensor::TensorIn;

@group(0) @binding(0) var input: TensorIn;
