// What the stages that visit object pixels alone share: set 1, the compacted surface. Object pixels
// are numbered row after row. The other side is src/gpu/pixels.rs.
#ifndef KLIEG_PIXELS
#define KLIEG_PIXELS

#include "layout.glsl"

// Individuals that share a pass over the pixels; their brightnesses stand together. As in
// src/gpu/runs.rs, and so the next.
const uint BLOCK = 4;
// Lights of a block, behind those that only alignment brings along.
const uint WINDOW = 72;

struct Taps {
    uint up; // number of the first object pixel that is not left of the one above
    uint down; // and of the one below
    uint present; // bit k: neighbour k of the nine, row after row, is an object pixel
    uint kind; // SURFACE or EDGE
};

layout(set = 1, binding = 0, std430) buffer RowCounts { uint row_counts[]; };
layout(set = 1, binding = 1, std430) buffer PixelTaps { Taps taps[]; };
layout(set = 1, binding = 2, std430) buffer PixelPlaces { uint places[]; }; // y * width + x
// The pixels' surface records, with room for some pixels more.
layout(set = 1, binding = 3, std430) buffer Positions { vec4 positions[]; }; // and shininess
layout(set = 1, binding = 4, std430) buffer Normals { vec4 normals[]; }; // and diffuse reflectance
layout(set = 1, binding = 5, std430) buffer Looks { vec2 looks[]; }; // specular and unlit
// Of each block of a chunk, all pixels.
layout(set = 1, binding = 6, std430) buffer Brightness { vec4 brightness[]; };
layout(set = 1, binding = 7, std140) uniform LightWindow { Light window[WINDOW]; };

#endif
