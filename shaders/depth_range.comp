#version 460
// Depth range: the largest depth of the object; the background lies 1 behind it.
// Reference: src/cpu/mod.rs, maps.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint top = gl_GlobalInvocationID.y * STRIP;
    if (x >= parameters.size.x) {
        return;
    }
    uint largest = 0u;
    for (uint y = top; y < min(top + STRIP, parameters.size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        if (is_object(pixel)) {
            largest = max(largest, ordered(object_depth(pixel)));
        }
    }
    if (largest != 0u) {
        atomicMax(largest_depth, largest);
    }
}
