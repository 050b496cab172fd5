#version 460
// Length of every picture's gradient, summed over SURFACE, and the contrast that it makes, summed
// over EDGE. An invocation walks down one column of one strip with a window of 3 x 3 pixels. A tap
// outside the object or the picture takes the centre's value. Reference: cpu::gradient.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint ROWS = SUM_ROWS; // of a strip

// Three neighbours of row y, NO_OBJECT outside the picture.
vec3 row(ivec2 pixel, int layer) {
    ivec2 last = ivec2(parameters.size) - 1;
    int y = clamp(pixel.y, 0, last.y);
    vec3 values = vec3(
        texelFetch(pictures, ivec3(max(pixel.x - 1, 0), y, layer), 0).x,
        texelFetch(pictures, ivec3(pixel.x, y, layer), 0).x,
        texelFetch(pictures, ivec3(min(pixel.x + 1, last.x), y, layer), 0).x);
    bvec3 outside = bvec3(pixel.x == 0, false, pixel.x == last.x);
    outside = y == pixel.y ? outside : bvec3(true);
    return mix(values, vec3(NO_OBJECT), outside);
}

vec3 or_center(vec3 values, float center) {
    return mix(values, vec3(center), lessThan(values, vec3(0.0)));
}

void main() {
    uint x = gl_GlobalInvocationID.x;
    if (x >= parameters.size.x) {
        return;
    }
    uint strip = gl_WorkGroupID.y;
    int layer = int(gl_WorkGroupID.z);
    Gradient total = Gradient(0.0, 0.0);
    ivec2 pixel = ivec2(x, strip * ROWS);
    int end = int(min((strip + 1) * ROWS, parameters.size.y));
    vec3 above = row(pixel - ivec2(0, 1), layer);
    vec3 here = row(pixel, layer);
    for (; pixel.y < end; ++pixel.y) {
        vec3 below = row(pixel + ivec2(0, 1), layer);
        float center = here.y;
        vec3 a = or_center(above, center);
        vec3 h = or_center(here, center);
        vec3 b = or_center(below, center);
        vec2 sobel = vec2((a.z + 2.0 * h.z + b.z) - (a.x + 2.0 * h.x + b.x),
                          (b.x + 2.0 * b.y + b.z) - (a.x + 2.0 * a.y + a.z)) / 8.0;
        float slope = length(sobel);
        uint kind = type_at(pixel);
        total.surface += kind == SURFACE ? slope : 0.0;
        total.edge += kind == EDGE ? min(slope / parameters.edge_contrast, 1.0) : 0.0;
        above = here;
        here = below;
    }
    uint entry = (layer * gl_NumWorkGroups.y + strip) * parameters.size.x + x;
    gradient_parts[entry] = total;
}
