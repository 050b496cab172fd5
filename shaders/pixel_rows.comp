#version 460
// How many object pixels each row has.
#extension GL_GOOGLE_include_directive : require
#include "pixels.glsl"

layout(local_size_x_id = 0) in;

void main() {
    uint y = gl_GlobalInvocationID.x;
    if (y >= parameters.size.y) {
        return;
    }
    uint count = 0;
    for (uint x = 0; x < parameters.size.x; ++x) {
        count += type_at(ivec2(x, y)) != BACKGROUND ? 1 : 0;
    }
    row_counts[y] = count;
}
