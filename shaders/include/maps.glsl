// What the stages that run once for each view share: set 1, their scratch memory
// and the maps that they write. The other side is
// src/gpu/view/maps.rs.
#ifndef KLIEG_MAPS
#define KLIEG_MAPS

#include "layout.glsl"

layout(set = 1, binding = 0, std430) buffer DepthRange { uint largest_depth; };
layout(set = 1, binding = 1, std430) buffer Visible { uint visible[]; };
// Sums over a strip of the picture.
struct ShapePart {
    float gradient; // over SURFACE: |grad n|
    float weight; // and min(|grad n|, DETAIL_MOST)
    float x; // over the object: the normals' components
    float y;
    float xx; // their products
    float xy;
    float yy;
    float base; // the base colour's luminance
};
layout(set = 1, binding = 2, std430) buffer Partials { ShapePart partials[]; };

layout(set = 1, binding = 3, r32f) uniform writeonly image2D depth_map;
layout(set = 1, binding = 4, r32f) uniform image2D sobel_map;
layout(set = 1, binding = 5, r32f) uniform image2D laplace_map;
layout(set = 1, binding = 6, r32ui) uniform writeonly uimage2D types_out;

// A work group's invocations stand side by side; each takes a strip of so many pixels downwards.
layout(constant_id = 2) const uint STRIP = MAP_STRIP;

// Floats as integers of the same order above 0, so that atomicMax finds the largest.
uint ordered(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float from_ordered(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0u ? key & 0x7fffffffu : ~key);
}

bool inside(ivec2 pixel) {
    return all(greaterThanEqual(pixel, ivec2(0)))
        && all(lessThan(pixel, ivec2(parameters.size)));
}

bool is_object(ivec2 pixel) {
    return texelFetch(code_map, pixel, 0).r != 0u;
}

// Distance along the view axis, scene radii.
float object_depth(ivec2 pixel) {
    return parameters.eye.z - texelFetch(position_roughness_map, pixel, 0).z;
}

#endif
