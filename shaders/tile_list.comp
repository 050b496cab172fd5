#version 460
// The tiles of a picture, each with one of its object pixels, for a view whose types the host does not
// know. A work group looks through one tile. Reference: tiles() in src/gpu/measure/tiles.rs.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "tile.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint SIDE = TILE_SIDE; // of a tile, pixels

layout(set = 1, binding = 0, std430) writeonly buffer Tiles { Tile tiles[]; };

shared uint first; // object pixel, rows from the top

void main() {
    if (gl_LocalInvocationIndex == 0) {
        first = SIDE * SIDE;
    }
    barrier();
    ivec2 corner = ivec2(gl_WorkGroupID.xy * SIDE);
    for (uint k = gl_LocalInvocationIndex; k < SIDE * SIDE; k += gl_WorkGroupSize.x) {
        ivec2 pixel = corner + ivec2(k % SIDE, k / SIDE);
        if (all(lessThan(pixel, ivec2(parameters.size)))
            && type_at(pixel) != BACKGROUND) {
            atomicMin(first, k);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0) {
        uint place = (first / SIDE + 1) * (SIDE + 2) + first % SIDE + 1;
        uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
        uint origin = first < SIDE * SIDE ? place : EMPTY_TILE;
        tiles[number] = Tile(gl_WorkGroupID.x, gl_WorkGroupID.y, origin);
    }
}
