#version 460
// Histogram of every picture over its object pixels, plain and by curvature. An invocation walks down one
// column of one strip and counts in bytes, four bins a word, with neither shared memory nor atomics.
// Reference: cpu::histogram.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "appearance.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint ROWS = HISTOGRAM_ROWS; // of a strip
layout(constant_id = 2) const uint BINS = HISTOGRAM_BINS;
layout(constant_id = 3) const bool CURVATURE = false;
const uint WORDS = BINS / 4;
const uint CURVED_WORDS = CURVATURE ? BINS / 2 : 0;

void main() {
    uint x = gl_GlobalInvocationID.x;
    if (x >= parameters.size.x) {
        return;
    }
    uint strip = gl_WorkGroupID.y;
    uint layer = gl_WorkGroupID.z;
    uint words[WORDS];
    for (uint w = 0; w < WORDS; ++w) {
        words[w] = 0;
    }
    uint curved[BINS / 2];
    for (uint w = 0; w < CURVED_WORDS; ++w) {
        curved[w] = 0;
    }
    uint end = min((strip + 1) * ROWS, parameters.size.y);
    for (uint y = strip * ROWS; y < end; ++y) {
        float value = texelFetch(pictures, ivec3(x, y, layer), 0).x;
        uint bin = min(uint(max(value, 0.0) * float(BINS)), BINS - 1);
        uint one = value >= 0.0 ? 1u << (8 * (bin & 3)) : 0u;
        for (uint w = 0; w < WORDS; ++w) {
            words[w] += (bin >> 2) == w ? one : 0u;
        }
        if (CURVATURE && value >= 0.0) {
            uint level = curvature_level(texelFetch(color_surface, ivec3(x, y, 1), 0).w);
            for (uint w = 0; w < CURVED_WORDS; ++w) {
                curved[w] += (bin >> 1) == w ? level << (16 * (bin & 1)) : 0u;
            }
        }
    }
    uint entry = (layer * gl_NumWorkGroups.y + strip) * parameters.size.x + x;
    for (uint w = 0; w < WORDS; ++w) {
        histogram_parts[entry * (WORDS + CURVED_WORDS) + w] = words[w];
    }
    for (uint w = 0; w < CURVED_WORDS; ++w) {
        histogram_parts[entry * (WORDS + CURVED_WORDS) + WORDS + w] = curved[w];
    }
}
