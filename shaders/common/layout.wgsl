// How an image is laid out in a buffer, in elements.

struct Layout {
    offset: u32,
    row_stride: u32,
    pixel_stride: u32,
    channels: u32,           // of a pixel; a fourth one is its alpha
}

// The first element of a pixel.
fn element_of(image: Layout, at: vec2<u32>) -> u32 {
    return image.offset + at.y * image.row_stride + at.x * image.pixel_stride;
}
