// Tensors: texel (x, y) of layer q holds channels 4q … 4q + 3.

@if(tensor_f16) alias TensorIn = texture_storage_2d_array<rgba16float, read>;
@else alias TensorIn = texture_storage_2d_array<rgba32float, read>;

@if(tensor_f16) alias TensorOut = texture_storage_2d_array<rgba16float, write>;
@else alias TensorOut = texture_storage_2d_array<rgba32float, write>;

// A value as the tensor stores it. In 16 bits, this is the nearest float, ties to even, for values
// up to 65504: a plain store may round towards 0, so that every layer would make its output a
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
