// Blocks are squares of pixels, counted from the tile's origin.

const BLOCK = 16u;           // pixels per side
