#version 460
// Visible polygons: a bit for each colour code, set where it occurs.
// Reference: src/cpu/visible.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint top = gl_GlobalInvocationID.y * STRIP;
    if (x >= parameters.size.x) {
        return;
    }
    uint last = 0u;
    for (uint y = top; y < min(top + STRIP, parameters.size.y); ++y) {
        uint code = texelFetch(code_map, ivec2(x, y), 0).r;
        if (code != 0u && code != last) {
            atomicOr(visible[code / 32u], 1u << (code % 32u));
            last = code;
        }
    }
}
