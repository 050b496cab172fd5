// Pixel types: EDGE, SURFACE or BACKGROUND, and how many there are of the first two.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x = 64) in;

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint top = gl_GlobalInvocationID.y * STRIP;
    if (x >= size.x) {
        return;
    }
    uint counts[3] = uint[3](0u, 0u, 0u);
    for (uint y = top; y < min(top + STRIP, size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        uint at = index_of(pixel);
        bool edge = sobel[at] > edge_sobel && abs(laplace[at]) > edge_laplace;
        uint type = !is_object(pixel) ? BACKGROUND : edge ? EDGE : SURFACE;
        types[at] = type;
        ++counts[type];
    }
    atomicAdd(statistics.surface, counts[SURFACE]);
    atomicAdd(statistics.edge, counts[EDGE]);
}
