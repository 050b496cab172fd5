// A tile of the picture, as the pipeline `compute` takes it on GPUs; the Rust side is Tile in
// src/gpu/layout/.
#ifndef KLIEG_TILE
#define KLIEG_TILE

struct Tile {
    uint column; // of tiles
    uint row;
    uint origin; // an object pixel's place in the tile with its border, or EMPTY_TILE
};

#endif
