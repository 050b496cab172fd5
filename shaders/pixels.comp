#version 460
// The surface's records without the background. An invocation walks along a row, with its
// neighbours above and below. Reference: cpu::pixels.
#extension GL_GOOGLE_include_directive : require
#include "pixels.glsl"

layout(local_size_x_id = 0) in;

// Which of (x, y - 1), (x, y) and (x, y + 1) are object pixels.
bvec3 column(int x, int y) {
    ivec2 last = ivec2(parameters.size) - 1;
    bvec3 object = bvec3(false);
    if (x <= last.x) {
        object.x = y > 0 && type_at(ivec2(x, y - 1)) != BACKGROUND;
        object.y = type_at(ivec2(x, y)) != BACKGROUND;
        object.z = y < last.y && type_at(ivec2(x, y + 1)) != BACKGROUND;
    }
    return object;
}

// The bits of a column of the neighbourhood.
uint bits(bvec3 object) {
    return uint(object.x) | uint(object.y) << 3 | uint(object.z) << 6;
}

void main() {
    uint y = gl_GlobalInvocationID.x;
    if (y >= parameters.size.y) {
        return;
    }
    uint number = 0;
    for (uint above = 0; above < y; ++above) {
        number += row_counts[above];
    }
    uint up = number - (y > 0 ? row_counts[y - 1] : 0);
    uint down = number + row_counts[y];
    bvec3 left = bvec3(false);
    bvec3 middle = column(0, int(y));
    for (uint x = 0; x < parameters.size.x; ++x) {
        bvec3 right = column(int(x) + 1, int(y));
        if (middle.y) {
            ivec2 pixel = ivec2(x, y);
            vec3 look = texelFetch(surface_2, pixel, 0).xyz; // specular, unlit, type
            uint present = bits(left) | bits(middle) << 1 | bits(right) << 2;
            imageStore(taps_out, int(number), uvec4(up, down, present, uint(look.z)));
            places[number] = y * parameters.size.x + x;
            imageStore(positions_out, int(number), texelFetch(surface_0, pixel, 0));
            imageStore(normals_out, int(number), texelFetch(surface_1, pixel, 0));
            looks_out[number] = look.xy;
        }
        up += uint(middle.x);
        number += uint(middle.y);
        down += uint(middle.z);
        left = middle;
        middle = right;
    }
}
