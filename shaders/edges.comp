// Edges: Sobel pair and Laplacian of the depth; the picture's border repeats.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x = 64) in;

float depth_at(ivec2 pixel, float background) {
    ivec2 at = clamp(pixel, ivec2(0), ivec2(size) - 1);
    return is_object(at) ? texelFetch(position_depth_map, at, 0).w : background;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) {
        return;
    }
    float background = statistics.depth == 0u ? 1.0 : from_ordered(statistics.depth) + 1.0;
    float d[9];
    for (int k = 0; k < 9; ++k) {
        d[k] = depth_at(pixel + ivec2(k % 3 - 1, k / 3 - 1), background);
    }
    precise float gx = ((d[2] - d[0]) + 2.0 * (d[5] - d[3]) + (d[8] - d[6])) / 8.0;
    precise float gy = ((d[6] - d[0]) + 2.0 * (d[7] - d[1]) + (d[8] - d[2])) / 8.0;
    precise float around = d[0] + d[1] + d[2] + d[3] + d[5] + d[6] + d[7] + d[8];
    sobel[index_of(pixel)] = sqrt(gx * gx + gy * gy);
    laplace[index_of(pixel)] = (around - 8.0 * d[4]) / 8.0;
}
