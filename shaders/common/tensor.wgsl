// Tensors: texel (x, y) of layer q holds channels 4q … 4q + 3.

@if(tensor_f16) alias TensorIn = texture_storage_2d_array<rgba16float, read>;
@else alias TensorIn = texture_storage_2d_array<rgba32float, read>;

@if(tensor_f16) alias TensorOut = texture_storage_2d_array<rgba16float, write>;
@else alias TensorOut = texture_storage_2d_array<rgba32float, write>;

// A value as the tensor holds it. In 16 bits: the nearest float, to even where two are as near, of
// values up to 65504. A store alone may round towards 0, and every layer would make what it stores a
// little smaller. Below 2^-14, where 16-bit floats have fewer bits, the store still rounds.
@if(tensor_f16)
fn stored(value: vec4<f32>) -> vec4<f32> {
    let bits = bitcast<vec4<u32>>(value);
    let odd = (bits >> vec4(13u)) & vec4(1u);
    return bitcast<vec4<f32>>((bits + vec4(0xfffu) + odd) & vec4(0xffffe000u));
}
@else
fn stored(value: vec4<f32>) -> vec4<f32> {
    return value;
}
