// Depth range: the largest depth of the object; the background lies 1 behind it.
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
    uint largest = 0u;
    for (uint y = top; y < min(top + STRIP, size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        if (is_object(pixel)) {
            largest = max(largest, ordered(texelFetch(position_depth_map, pixel, 0).w));
        }
    }
    if (largest != 0u) {
        atomicMax(statistics.depth, largest);
    }
}
