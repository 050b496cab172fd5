#version 460
// Pixel types: EDGE, SURFACE or BACKGROUND, and how many there are of the first two.
// Reference: src/cpu/pixel_types.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

uint type_of(ivec2 pixel) {
    if (!is_object(pixel)) {
        return BACKGROUND;
    }
    bool edge = imageLoad(sobel_map, pixel).x > parameters.edge_sobel
        && abs(imageLoad(laplace_map, pixel).x) > parameters.edge_laplace;
    return edge ? EDGE : SURFACE;
}

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint top = gl_GlobalInvocationID.y * STRIP;
    if (x >= parameters.size.x) {
        return;
    }
    uint surface = 0u;
    uint edge = 0u;
    for (uint y = top; y < min(top + STRIP, parameters.size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        uint type = type_of(pixel);
        imageStore(types_out, pixel, uvec4(type));
        surface += uint(type == SURFACE);
        edge += uint(type == EDGE);
    }
    atomicAdd(view_statistics.surface, surface);
    atomicAdd(view_statistics.edge, edge);
}
