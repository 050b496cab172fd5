// What the stages that visit object pixels alone share: set 1, the compacted surface. Object pixels
// are numbered row after row. The other side is src/gpu/measure/pixels.rs.
#ifndef KLIEG_PIXELS
#define KLIEG_PIXELS

#include "layout.glsl"

// Individuals that share a pass over the pixels; their brightnesses stand together.
const uint BLOCK = RUNS_BLOCK;

layout(set = 1, binding = 0, std430) buffer RowCounts { uint row_counts[]; };
layout(set = 1, binding = 1, std430) buffer PixelPlaces {
    uint places[]; // y * width + x
};

// What there is of each pixel, with room for some pixels more. All of it is read as texels: software
// devices read and write storage buffers lane by lane, a branch and a word at a time.
layout(set = 1, binding = 2, rgba32ui) uniform writeonly uimageBuffer taps_out;
layout(set = 1, binding = 3, rgba32f) uniform writeonly imageBuffer positions_out;
layout(set = 1, binding = 4, rgba32f) uniform writeonly imageBuffer normals_out;
layout(set = 1, binding = 5, std430) writeonly buffer Looks { vec2 looks_out[]; };
layout(set = 1, binding = 6, rgba32f) uniform writeonly imageBuffer brightness_out;
// Its neighbours. x: number of the first object pixel that is not left of the one above; y: and of
// the one below; z: bit k tells whether neighbour k of the nine, row after row, is an object pixel;
// w: SURFACE or EDGE.
layout(set = 1, binding = 7) uniform utextureBuffer taps;
// The surface records: position and shininess; normal and diffuse reflectance; specular reflectance
// and unlit luminance.
layout(set = 1, binding = 8) uniform textureBuffer positions;
layout(set = 1, binding = 9) uniform textureBuffer normals;
layout(set = 1, binding = 10) uniform textureBuffer looks;
// Under the individuals of each block of a chunk, all pixels of one block after those of another. In
// colour the irradiances of a block follow its brightnesses; see encoded() in color.glsl.
layout(set = 1, binding = 11) uniform textureBuffer brightness;

layout(set = 1, binding = 12, std140) uniform LightWindow { Light window[LIGHT_WINDOW]; };

// Where an object pixel is in the picture.
ivec2 pixel_of(uint number) {
    uint place = places[number];
    return ivec2(place % parameters.size.x, place / parameters.size.x);
}

// Room for the pixels of a block.
uint stride() {
    return uint(textureSize(positions));
}

#endif
