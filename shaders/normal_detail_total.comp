#version 460
// Normal detail G_n, second half: the strips' sums in a fixed order, over the SURFACE pixels. One
// work group.
// Reference: src/cpu/normal_detail.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0) in;

shared float sums[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint lanes = gl_WorkGroupSize.x; // a power of two
    uint strips = (parameters.size.y + STRIP - 1u) / STRIP * parameters.size.x;
    float sum = 0.0;
    for (uint k = lane; k < strips; k += lanes) {
        sum += partials[k];
    }
    sums[lane] = sum;
    for (uint rest = lanes / 2u; rest > 0u; rest /= 2u) {
        barrier();
        if (lane < rest) {
            sums[lane] += sums[lane + rest];
        }
    }
    if (lane == 0u) {
        view_statistics.normal_detail = sums[0] / float(max(view_statistics.surface, 1u));
    }
}
