#version 460
// What the lights do in every picture, the detail that is seen, and the outline. An invocation walks down one column
// of one strip. References: cpu::appearance, cpu::gradient.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "appearance.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint ROWS = SUM_ROWS; // of a strip
layout(constant_id = 2) const bool LIGHTS = false; // what is measured
layout(constant_id = 3) const bool DETAIL = false;
layout(constant_id = 4) const bool TARGET = false;
layout(constant_id = 5) const bool OUTLINE = false;

// A tap outside the object or the picture takes the centre's value.
float tap(ivec2 pixel, int layer, float center) {
    ivec2 last = ivec2(parameters.size) - 1;
    float value = texelFetch(pictures, ivec3(clamp(pixel, ivec2(0), last), layer), 0).x;
    return pixel == clamp(pixel, ivec2(0), last) && value >= 0.0 ? value : center;
}

float slope(ivec2 at, int layer, float center) {
    float a = tap(at + ivec2(-1, -1), layer, center);
    float b = tap(at + ivec2(0, -1), layer, center);
    float c = tap(at + ivec2(1, -1), layer, center);
    float d = tap(at + ivec2(-1, 0), layer, center);
    float f = tap(at + ivec2(1, 0), layer, center);
    float g = tap(at + ivec2(-1, 1), layer, center);
    float h = tap(at + ivec2(0, 1), layer, center);
    float i = tap(at + ivec2(1, 1), layer, center);
    return length(vec2((c + 2.0 * f + i) - (a + 2.0 * d + g),
        (g + 2.0 * h + i) - (a + 2.0 * b + c))) / 8.0;
}

void main() {
    uint x = gl_GlobalInvocationID.x;
    if (x >= parameters.size.x) {
        return;
    }
    uint strip = gl_WorkGroupID.y;
    int layer = int(gl_WorkGroupID.z);
    Sums sums = no_sums();
    uint end = min((strip + 1) * ROWS, parameters.size.y);
    for (uint y = strip * ROWS; y < end; ++y) {
        ivec2 pixel = ivec2(x, y);
        vec2 value = texelFetch(pictures, ivec3(pixel, layer), 0).xy;
        if (value.x < 0.0) {
            continue;
        }
        if (LIGHTS) {
            add_lights(value.y, texelFetch(surface_1, pixel, 0).xy, sums);
        }
        if (DETAIL && type_at(pixel) == SURFACE) {
            add_detail(slope(pixel, layer, value.x), texelFetch(color_surface, ivec3(pixel, 1), 0).w, sums);
        }
        if (TARGET) {
            add_target(value.x, texelFetch(color_surface, ivec3(pixel, 2), 0).w, sums);
        }
        if (OUTLINE && is_outline(pixel)) {
            add_outline(value.x, sums);
        }
    }
    uint entry = (layer * gl_NumWorkGroups.y + strip) * parameters.size.x + x;
    appearance_parts[entry] = part_of(sums);
}
