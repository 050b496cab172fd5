#version 460
// Histogram, moments and gradients of a block of individuals over a run of object pixels. An
// invocation takes every so many pixels of it and keeps its sums in registers: no shared memory, no
// atomics. Twins: cpu::histogram, cpu::moments, cpu::gradient.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pixels.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 0) const uint GROUP = 8;
layout(constant_id = 1) const uint PIXELS = 128; // of an invocation; at most 255, as a byte counts them
layout(constant_id = 2) const uint BINS = 32;
const uint WORDS = BINS / 4;

// Brightness at neighbour k, which has the given number, or the centre's.
vec4 tap(uint base, uint present, uint k, uint number, uint center) {
    return brightness[base + ((present >> k & 1) != 0 ? number : center)];
}

void main() {
    uint objects = view_statistics.surface + view_statistics.edge;
    uint base = (gl_WorkGroupID.y) * (records.length() / 3);
    uint words[BLOCK][WORDS];
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        [[unroll]] for (uint w = 0; w < WORDS; ++w) {
            words[i][w] = 0;
        }
    }
    uint number = gl_WorkGroupID.x * GROUP * PIXELS + gl_LocalInvocationIndex;
    uint count = 0;
    vec4 origin = brightness[base + min(number, objects - 1)];
    vec4 sum = vec4(0.0);
    vec4 squares = vec4(0.0);
    vec4 surface = vec4(0.0);
    vec4 edge = vec4(0.0);
    for (uint k = 0; k < PIXELS && number < objects; ++k) {
        Taps at = taps[number];
        uint present = at.present;
        uint up = at.up + (present >> 1 & 1);
        uint down = at.down + (present >> 7 & 1);
        vec4 center = brightness[base + number];
        vec4 a = tap(base, present, 0, at.up - 1, number);
        vec4 b = tap(base, present, 1, at.up, number);
        vec4 c = tap(base, present, 2, up, number);
        vec4 d = tap(base, present, 3, number - 1, number);
        vec4 f = tap(base, present, 5, number + 1, number);
        vec4 g = tap(base, present, 6, at.down - 1, number);
        vec4 h = tap(base, present, 7, at.down, number);
        vec4 i = tap(base, present, 8, down, number);
        vec4 x = (c + 2.0 * f + i) - (a + 2.0 * d + g);
        vec4 y = (g + 2.0 * h + i) - (a + 2.0 * b + c);
        vec4 slope = sqrt(x * x + y * y) / 8.0;
        if (at.kind == SURFACE) {
            surface += slope;
        } else {
            edge += min(slope / parameters.edge_contrast, vec4(1.0));
        }
        vec4 distance = center - origin;
        sum += distance;
        squares += distance * distance;
        uvec4 bin = min(uvec4(center * float(BINS)), uvec4(BINS - 1));
        uvec4 one = uvec4(1) << (8 * (bin & 3));
        [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
            [[unroll]] for (uint w = 0; w < WORDS; ++w) {
                words[j][w] += (bin[j] >> 2) == w ? one[j] : 0u;
            }
        }
        ++count;
        number += GROUP;
    }
    vec4 mean = count > 0 ? sum / float(count) : vec4(0.0);
    vec4 deviation = max(squares - sum * mean, vec4(0.0));
    uint entries = chunk.entries;
    uint entry = gl_WorkGroupID.y * BLOCK * entries + gl_GlobalInvocationID.x;
    [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
        [[unroll]] for (uint w = 0; w < WORDS; ++w) {
            histogram_parts[entry * WORDS + w] = words[j][w];
        }
        moment_parts[entry] = Moments(count, count > 0 ? origin[j] + mean[j] : 0.0, deviation[j]);
        gradient_parts[entry] = Gradient(surface[j], edge[j]);
        entry += entries;
    }
}
