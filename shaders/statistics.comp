#version 460
// Histogram, moments and gradients of a block of individuals. An invocation walks along a run of
// object pixels, with its neighbours above and below, and keeps its sums in registers: no shared
// memory, no atomics. References: cpu::histogram, cpu::moments, cpu::gradient.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pixels.glsl"
#include "appearance.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 0) const uint GROUP = STATISTICS_GROUP;
layout(constant_id = 1) const uint PIXELS = RUN_PIXELS; // of an invocation
layout(constant_id = 2) const uint BINS = HISTOGRAM_BINS;
layout(constant_id = 3) const bool LIGHTS = false; // what is measured besides
layout(constant_id = 4) const bool DETAIL = false;
layout(constant_id = 5) const bool TARGET = false;
layout(constant_id = 6) const bool OUTLINE = false;
layout(constant_id = 7) const bool CURVATURE = false;
layout(constant_id = 8) const bool COLOR = false; // whether irradiances stand behind the brightnesses
const uint WORDS = BINS / 4;
const uint CURVED_WORDS = CURVATURE ? BINS / 2 : 0;
const bool APPEARANCE = LIGHTS || DETAIL || TARGET || OUTLINE;

// Three brightnesses side by side; those of the middle and the left one wander on to the next pixel.
struct Row {
    vec4 left;
    vec4 middle;
    vec4 right;
};

vec4 brightness_at(uint number) {
    return texelFetch(brightness, int(number));
}

// The brightnesses of neighbours k, k + 1 and k + 2, or the centre's where they are not there.
Row present_or(Row row, uint present, uint k, vec4 center) {
    return Row((present >> k & 1) != 0 ? row.left : center,
        (present >> k + 1 & 1) != 0 ? row.middle : center,
        (present >> k + 2 & 1) != 0 ? row.right : center);
}

void main() {
    uint objects = view_statistics.surface + view_statistics.edge;
    uint base = gl_WorkGroupID.y * stride() * (COLOR ? 2 : 1);
    uint words[BLOCK][WORDS];
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        [[unroll]] for (uint w = 0; w < WORDS; ++w) {
            words[i][w] = 0;
        }
    }
    uint curved[BLOCK][BINS / 2];
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        [[unroll]] for (uint w = 0; w < CURVED_WORDS; ++w) {
            curved[i][w] = 0;
        }
    }
    uint first = gl_GlobalInvocationID.x * PIXELS;
    uint end = min(first + PIXELS, objects);
    vec4 origin = brightness_at(base + min(first, max(objects, 1) - 1));
    vec4 sum = vec4(0.0);
    vec4 squares = vec4(0.0);
    vec4 surface = vec4(0.0);
    vec4 edge = vec4(0.0);
    Row above;
    Row here;
    Row below;
    Sums sums[BLOCK];
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        sums[i] = no_sums();
    }
    bool follows = false; // whether the pixel before is the left neighbour
    for (uint number = first; number < end; ++number) {
        uvec4 at = texelFetch(taps, int(number));
        uint present = at.z;
        uint last = base + objects - 1;
        if (follows) {
            above.left = above.middle;
            here.left = here.middle;
            below.left = below.middle;
            above.middle = above.right;
            here.middle = here.right;
            below.middle = below.right;
        } else {
            above.left = brightness_at(clamp(base + at.x - 1, base, last));
            above.middle = brightness_at(min(base + at.x, last));
            here.left = brightness_at(clamp(base + number - 1, base, last));
            here.middle = brightness_at(base + number);
            below.left = brightness_at(clamp(base + at.y - 1, base, last));
            below.middle = brightness_at(min(base + at.y, last));
        }
        above.right = brightness_at(min(base + at.x + (present >> 1 & 1), last));
        here.right = brightness_at(min(base + number + 1, last));
        below.right = brightness_at(min(base + at.y + (present >> 7 & 1), last));
        follows = (present >> 5 & 1) != 0;

        vec4 center = here.middle;
        Row a = present_or(above, present, 0, center);
        Row h = present_or(here, present, 3, center);
        Row b = present_or(below, present, 6, center);
        vec4 x = (a.right + 2.0 * h.right + b.right) - (a.left + 2.0 * h.left + b.left);
        vec4 y = (b.left + 2.0 * b.middle + b.right) - (a.left + 2.0 * a.middle + a.right);
        vec4 slope = sqrt(x * x + y * y) / 8.0;
        bool inner = at.w == SURFACE;
        surface += inner ? slope : vec4(0.0);
        edge += inner ? vec4(0.0) : min(slope / parameters.edge_contrast, vec4(1.0));
        if (APPEARANCE) {
            ivec2 pixel = pixel_of(number);
            vec2 n = texelFetch(normals, int(number)).xy;
            vec4 light = LIGHTS ? brightness_at(base + stride() + number) : vec4(0.0);
            float gradient = DETAIL ? texelFetch(color_surface, ivec3(pixel, 1), 0).w : 0.0;
            float target = TARGET ? texelFetch(color_surface, ivec3(pixel, 2), 0).w : NO_TARGET;
            bool outline = OUTLINE && present != 0x1ff && is_outline(pixel);
            [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
                if (LIGHTS) {
                    add_lights(light[j], n, sums[j]);
                }
                if (DETAIL && inner) {
                    add_detail(slope[j], gradient, sums[j]);
                }
                if (TARGET) {
                    add_target(center[j], target, sums[j]);
                }
                if (outline) {
                    add_outline(center[j], sums[j]);
                }
            }
        }
        vec4 distance = center - origin;
        sum += distance;
        squares += distance * distance;
        uvec4 bin = min(uvec4(center * float(BINS)), uvec4(BINS - 1));
        uvec4 one = uvec4(1) << (8 * (bin & 3));
        [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
            [[unroll]] for (uint w = 0; w < WORDS; ++w) {
                words[j][w] += (bin[j] >> 2) == w ? one[j] : 0u;
            }
        }
        if (CURVATURE) {
            uint level = curvature_level(texelFetch(color_surface, ivec3(pixel_of(number), 1), 0).w);
            uvec4 weight = uvec4(level) << (16 * (bin & 1));
            [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
                [[unroll]] for (uint w = 0; w < CURVED_WORDS; ++w) {
                    curved[j][w] += (bin[j] >> 1) == w ? weight[j] : 0u;
                }
            }
        }
    }
    uint count = end > first ? end - first : 0;
    vec4 mean = count > 0 ? sum / float(count) : vec4(0.0);
    vec4 deviation = max(squares - sum * mean, vec4(0.0));
    uint entries = chunk.entries;
    uint entry = gl_WorkGroupID.y * BLOCK * entries + gl_GlobalInvocationID.x;
    [[unroll]] for (uint j = 0; j < BLOCK; ++j) {
        [[unroll]] for (uint w = 0; w < WORDS; ++w) {
            histogram_parts[entry * (WORDS + CURVED_WORDS) + w] = words[j][w];
        }
        [[unroll]] for (uint w = 0; w < CURVED_WORDS; ++w) {
            histogram_parts[entry * (WORDS + CURVED_WORDS) + WORDS + w] = curved[j][w];
        }
        moment_parts[entry] = Moments(count, count > 0 ? origin[j] + mean[j] : 0.0, deviation[j]);
        gradient_parts[entry] = Gradient(surface[j], edge[j]);
        if (APPEARANCE) {
            appearance_parts[entry] = part_of(sums[j]);
        }
        entry += entries;
    }
}
