// The noisy color that a kernel pyramid averages: repaired, neither exposed nor encoded.

import package::common::encoding::{SIGNED, transfer_function};
import package::common::fill::filled;
import package::common::images::COLOR;
import package::common::repair::repaired;

// In w, 1, or 0 for a pixel that is missing.
fn linear_color(at: vec2<u32>) -> vec4<f32> {
    if transfer_function == SIGNED {
        return vec4(filled(COLOR, at), 1.0);
    }
    return vec4(repaired(at), 1.0);
}
