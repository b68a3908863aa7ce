// Encodes exposed color for the network: from 0 to 1, or beyond 1 for light above 65504 if
// `brightest` allows it.

override transfer_function: u32;
const PU = 0u;
const LOG = 1u;
const SRGB = 2u;
const SIGNED = 3u;           // for values from −1 to 1

override brightest: f32;     // brighter light is clamped to this; PU and LOG map 65504 to 1

// Perceptually uniform encoding of luminance: the fit PU2 of Aydin et al. 2008, "Extending quality
// metrics to full luminance range images", scaled so that 65504 becomes 1. The plain names A, B and
// C are taken by the roles of cooperative matrices.
const PU_A = 1.41283765e3;
const PU_B = 1.64593172;
const PU_C = 0.431384981;
const PU_D = -2.94139609e-3;
const PU_E = 0.192653254;
const PU_F = 6.26026094e-3;
const PU_G = 0.998620152;
const Y0 = 1.57945760e-6;
const Y1 = 3.22087631e-2;
const X0 = 2.23151711e-3;
const X1 = 0.370974749;
const PU_SCALE = 1.0 / 3.13511904;
const LOG_SCALE = 1.0 / 11.0898818;

fn pu(y: vec3<f32>) -> vec3<f32> {
    let middle = PU_B * pow(y, vec3(PU_C)) + PU_D;
    let bright = PU_E * log(y + PU_F) + PU_G;
    return PU_SCALE * select(select(bright, middle, y <= vec3(Y1)), PU_A * y, y <= vec3(Y0));
}

fn inverse_pu(encoded: vec3<f32>) -> vec3<f32> {
    let x = encoded / PU_SCALE;
    let middle = pow(max((x - PU_D) / PU_B, vec3(0.0)), vec3(1.0 / PU_C));
    let bright = exp((x - PU_G) / PU_E) - PU_F;
    return max(select(select(bright, middle, x <= vec3(X1)), x / PU_A, x <= vec3(X0)), vec3(0.0));
}

fn srgb(y: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(y, vec3(1.0 / 2.4)) - 0.055, 12.92 * y, y <= vec3(0.0031308));
}

fn inverse_srgb(x: vec3<f32>) -> vec3<f32> {
    return select(pow((x + 0.055) / 1.055, vec3(2.4)), x / 12.92, x <= vec3(0.04045));
}

fn encode(exposed: vec3<f32>) -> vec3<f32> {
    switch transfer_function {
        case LOG: { return LOG_SCALE * log(min(exposed, vec3(brightest)) + 1.0); }
        case SRGB: { return srgb(clamp(exposed, vec3(0.0), vec3(1.0))); }
        case SIGNED: { return clamp(exposed, vec3(-1.0), vec3(1.0)) * 0.5 + 0.5; }
        default: { return pu(min(exposed, vec3(brightest))); }
    }
}

// The result is never brighter than the brightest input.
fn decode(network: vec3<f32>) -> vec3<f32> {
    let encoded = clamp(network, vec3(0.0), encode(vec3(brightest)));
    switch transfer_function {
        case LOG: { return exp(encoded / LOG_SCALE) - 1.0; }
        case SRGB: { return inverse_srgb(encoded); }
        case SIGNED: { return encoded * 2.0 - 1.0; }
        default: { return inverse_pu(encoded); }
    }
}
