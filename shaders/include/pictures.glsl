// Pictures of an engine as klieg's own. The including shader defines FORMAT: of one channel, the
// brightness, or of two, with -1 in the second where a channel is burnt out and 0 elsewhere.
#ifndef KLIEG_PICTURES
#define KLIEG_PICTURES

#include "layout.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const bool ENCODED = false;
layout(constant_id = 3) const bool RED = false;

layout(set = 1, binding = 0) uniform texture2DArray rendered;
layout(set = 2, binding = 0, FORMAT) uniform writeonly image2DArray made;

// At least this much of any channel is white, whatever the others.
const float WHITE = 16.0;

// 0 for what is negative or not a number. The bits of both are above those of infinity; a shader may not
// count on comparisons of floats to find what is not a number.
float within(float x, float most) {
    return floatBitsToUint(x) > 0x7f800000u ? 0.0 : min(x, most);
}

float linear(float channel) {
    return ENCODED ? srgb_decode(within(channel, 1.0)) : within(channel, WHITE);
}

// The brightness, and whether a channel is burnt out.
struct Seen {
    float brightness;
    bool burnt;
};

Seen seen(vec3 texel) {
    if (RED && ENCODED) {
        float value = within(texel.r, 1.0);
        return Seen(value, value >= BURNT);
    }
    vec3 color = vec3(linear(texel.r), linear(texel.g), linear(texel.b));
    color = RED ? color.rrr : color;
    float most = max(color.r, max(color.g, color.b));
    return Seen(srgb_encode(RED ? color.r : luminance(color)), most >= srgb_decode(BURNT));
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, ivec2(parameters.size)))) {
        return;
    }
    vec2 value = vec2(NO_OBJECT, 0.0);
    if (type_at(at.xy) != BACKGROUND) {
        Seen pixel = seen(texelFetch(rendered, at + ivec3(0, 0, chunk.first), 0).rgb);
        value = vec2(pixel.brightness, pixel.burnt ? -1.0 : 0.0);
    }
    imageStore(made, at, vec4(value, 0.0, 0.0));
}

#endif
