// Maps a pixel of the tile to one of the bound images.

import package::common::tile::tile;

// Beyond the image, its edge repeats.
fn place(pixel: vec2<u32>) -> vec2<u32> {
    return min(tile.origin + pixel, tile.image_size - 1u);
}
