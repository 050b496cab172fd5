#version 460
// Edges: the depth, its Sobel pair and its Laplacian; the picture's border repeats.
// Reference: src/cpu/edges.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

float depth_at(ivec2 pixel, float background) {
    ivec2 at = clamp(pixel, ivec2(0), ivec2(parameters.size) - 1);
    return is_object(at) ? object_depth(at) : background;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) {
        return;
    }
    float background = (largest_depth == 0u ? 0.0 : from_ordered(largest_depth)) + 1.0;
    if (pixel == ivec2(0)) {
        view_statistics.background_depth = background;
    }
    float centre = depth_at(pixel, background);
    float d[9]; // relative to the centre, so that little is lost in the sums
    float around = 0.0;
    for (int k = 0; k < 9; ++k) {
        d[k] = depth_at(pixel + ivec2(k % 3 - 1, k / 3 - 1), background) - centre;
        around += d[k];
    }
    float x = (d[2] - d[0]) + 2.0 * (d[5] - d[3]) + (d[8] - d[6]);
    float y = (d[6] - d[0]) + 2.0 * (d[7] - d[1]) + (d[8] - d[2]);
    imageStore(depth_map, pixel, vec4(centre));
    imageStore(sobel_map, pixel, vec4(length(vec2(x, y)) / 8.0));
    imageStore(laplace_map, pixel, vec4(around / 8.0));
}
