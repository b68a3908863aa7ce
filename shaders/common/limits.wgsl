// The largest finite floats.

const LARGEST_F16: f32 = 65504.0;
const LARGEST_F32: f32 = 3.4028234e38;
