// How an image is laid out in a buffer, in elements.

struct Layout {
    offset: u32,
    row_stride: u32,
    pixel_stride: u32,
    alpha: u32,              // 1 if the fourth element of a pixel is its alpha, else 0
}

// The first element of a pixel.
fn element_of(image: Layout, at: vec2<u32>) -> u32 {
    return image.offset + at.y * image.row_stride + at.x * image.pixel_stride;
}
