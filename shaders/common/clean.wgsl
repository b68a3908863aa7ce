// The blocks that skip the network.

import package::common::block::BLOCK;

// Whether each block of the tile is clean, row by row.
@group(0) @binding(5) var<storage, read> clean: array<u32>;

// `width` is that of the tile.
fn is_clean(pixel: vec2<u32>, width: u32) -> bool {
    let block = pixel / BLOCK;
    return clean[block.y * (width / BLOCK) + block.x] != 0u;
}
