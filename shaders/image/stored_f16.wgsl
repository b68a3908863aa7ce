
// The nearest 16-bit floats, to even where two are as near, of values up to 65504: a store alone may
// round towards 0, and every layer would make what it stores a little smaller. Below 2^-14, where
// 16-bit floats have fewer bits, the store still does.
fn stored(value: vec4<f32>) -> vec4<f32> {
    let bits = bitcast<vec4<u32>>(value);
    let odd = (bits >> vec4(13u)) & vec4(1u);
    return bitcast<vec4<f32>>((bits + vec4(0xfffu) + odd) & vec4(0xffffe000u));
}
