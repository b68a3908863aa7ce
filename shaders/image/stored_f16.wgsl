
// The nearest 16-bit floats, to even where two are as near: a store alone may round towards 0, and
// every layer would make what it stores a little smaller. Values are 65504 at most.
fn stored(value: vec4<f32>) -> vec4<f32> {
    let bits = bitcast<vec4<u32>>(value);
    let odd = (bits >> vec4(13u)) & vec4(1u);
    return bitcast<vec4<f32>>((bits + vec4(0xfffu) + odd) & vec4(0xffffe000u));
}
