// The arithmetic of the tiled kernels: 32-bit floats or, in the half set, 16-bit floats, which many
// GPUs multiply and add in pairs. A sum in 16 bits covers one chunk of input channels; the chunks
// add up in 32 bits.

@if(half && !(tensor_f16 && !input_conv)) import package::common::limits::LARGEST_F16;

@if(half) enable f16;

@if(half) alias Number = f16;
@else alias Number = f32;

// Column j of a matrix holds what input channel j adds to four outputs.
alias Taps = mat4x4<Number>;

// Sums of an invocation's 2×2 pixels, a and b above c and d, by output quad. Separate variables,
// because an array indexed in a loop would live in memory.
struct Sums {
    a0: vec4<f32>, a1: vec4<f32>, a2: vec4<f32>, a3: vec4<f32>,
    b0: vec4<f32>, b1: vec4<f32>, b2: vec4<f32>, b3: vec4<f32>,
    c0: vec4<f32>, c1: vec4<f32>, c2: vec4<f32>, c3: vec4<f32>,
    d0: vec4<f32>, d1: vec4<f32>, d2: vec4<f32>, d3: vec4<f32>,
}

// The same for one chunk.
@if(half)
struct ChunkSums {
    a0: vec4<f16>, a1: vec4<f16>, a2: vec4<f16>, a3: vec4<f16>,
    b0: vec4<f16>, b1: vec4<f16>, b2: vec4<f16>, b3: vec4<f16>,
    c0: vec4<f16>, c1: vec4<f16>, c2: vec4<f16>, c3: vec4<f16>,
    d0: vec4<f16>, d1: vec4<f16>, d2: vec4<f16>, d3: vec4<f16>,
}
@else alias ChunkSums = Sums;

// A value as it is multiplied. The values of a 16-bit tensor are within the range of 16 bits.
@if(!half)
fn staged(value: vec4<f32>) -> vec4<f32> {
    return value;
}
@elif(tensor_f16 && !input_conv)
fn staged(value: vec4<f32>) -> vec4<f16> {
    return vec4<f16>(value);
}
@else
fn staged(value: vec4<f32>) -> vec4<f16> {
    return vec4<f16>(clamp(value, vec4(-LARGEST_F16), vec4(LARGEST_F16)));
}

// A sum plus the products of four input channels.
@if(half)
fn plus(sum: vec4<f16>, w: Taps, value: vec4<f16>) -> vec4<f16> {
    let xy = fma(w[1], value.yyyy, fma(w[0], value.xxxx, sum));
    return fma(w[3], value.wwww, fma(w[2], value.zzzz, xy));
}
@else
fn plus(sum: vec4<f32>, w: Taps, value: vec4<f32>) -> vec4<f32> {
    return sum + w * value;
}

// Adds the sums of a chunk. Column q of `scales` undoes the scaling of output quad q's weights.
@if(half)
fn collected(s: Sums, chunk: ChunkSums, scales: mat4x4<f32>) -> Sums {
    return Sums(
        s.a0 + scales[0] * vec4<f32>(chunk.a0), s.a1 + scales[1] * vec4<f32>(chunk.a1),
        s.a2 + scales[2] * vec4<f32>(chunk.a2), s.a3 + scales[3] * vec4<f32>(chunk.a3),
        s.b0 + scales[0] * vec4<f32>(chunk.b0), s.b1 + scales[1] * vec4<f32>(chunk.b1),
        s.b2 + scales[2] * vec4<f32>(chunk.b2), s.b3 + scales[3] * vec4<f32>(chunk.b3),
        s.c0 + scales[0] * vec4<f32>(chunk.c0), s.c1 + scales[1] * vec4<f32>(chunk.c1),
        s.c2 + scales[2] * vec4<f32>(chunk.c2), s.c3 + scales[3] * vec4<f32>(chunk.c3),
        s.d0 + scales[0] * vec4<f32>(chunk.d0), s.d1 + scales[1] * vec4<f32>(chunk.d1),
        s.d2 + scales[2] * vec4<f32>(chunk.d2), s.d3 + scales[3] * vec4<f32>(chunk.d3),
    );
}
