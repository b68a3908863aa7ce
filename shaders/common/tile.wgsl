// The tile that a dispatch works on.

import package::common::layout::Layout;

struct Tile {
    image_size: vec2<u32>,   // of the bound images, pixels
    origin: vec2<u32>,       // the tile's first pixel in the bound images
    begin: vec2<u32>,        // the first pixel to store, in the bound images
    end: vec2<u32>,          // one past the last
    color: Layout,
    albedo: Layout,
    normal: Layout,
    output: Layout,
    beauty: Layout,
    motion: Layout,
    depth: Layout,
}

@group(0) @binding(0) var<uniform> tile: Tile;
