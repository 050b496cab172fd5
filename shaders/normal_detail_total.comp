// Normal detail G_n, second half: the strips' sums, in a fixed order, over the SURFACE pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

const uint GROUP = 256u;
layout(local_size_x = 256) in;

shared float sums[GROUP];

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint strips = (size.y + STRIP - 1u) / STRIP * size.x;
    float sum = 0.0;
    for (uint k = lane; k < strips; k += GROUP) {
        sum += partials[k];
    }
    sums[lane] = sum;
    for (uint half_group = GROUP / 2u; half_group > 0u; half_group /= 2u) {
        barrier();
        if (lane < half_group) {
            sums[lane] += sums[lane + half_group];
        }
    }
    if (lane == 0u) {
        statistics.normal_detail =
            statistics.surface == 0u ? 0.0 : sums[0] / float(statistics.surface);
    }
}
