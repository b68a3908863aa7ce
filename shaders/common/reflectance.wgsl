// The albedo as the network sees it.

import package::common::fill::filled;
import package::common::images::ALBEDO;

fn reflectance(at: vec2<u32>) -> vec3<f32> {
    return clamp(filled(ALBEDO, at).rgb, vec3(0.0), vec3(1.0));
}
