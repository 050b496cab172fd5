#version 460
// Pictures that an engine has rendered, a layer for each individual, as klieg's own: the encoded
// luminance of the object pixels. Reference: cpu::pictures.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const bool ENCODED = false;
layout(constant_id = 3) const bool RED = false;

layout(set = 1, binding = 0) uniform texture2DArray rendered;
layout(set = 2, binding = 0, r32f) uniform writeonly image2DArray made;

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

float brightness(vec3 texel) {
    if (RED && ENCODED) {
        return within(texel.r, 1.0);
    }
    vec3 color = vec3(linear(texel.r), linear(texel.g), linear(texel.b));
    return srgb_encode(RED ? color.r : luminance(color));
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, ivec2(parameters.size)))) {
        return;
    }
    float value = NO_OBJECT;
    if (imageLoad(type_map, at.xy).x != BACKGROUND) {
        value = brightness(texelFetch(rendered, at + ivec3(0, 0, chunk.first), 0).rgb);
    }
    imageStore(made, at, vec4(value));
}
