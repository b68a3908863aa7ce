// 16-bit floats in a storage buffer, two to a word.

// The bits of element `i`, which lies in `word`, as a 32-bit float. unpack2x16float need not keep NaN
// and infinity.
fn widened(word: u32, i: u32) -> u32 {
    let half = (word >> (16u * (i & 1u))) & 0xffffu;
    let special = ((half & 0x8000u) << 16u) | 0x7f800000u | ((half & 0x3ffu) << 13u);
    return select(bitcast<u32>(unpack2x16float(half).x), special, (half & 0x7c00u) == 0x7c00u);
}
