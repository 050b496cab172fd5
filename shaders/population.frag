#version 460
// One pixel of one individual's picture: the stored surface under the individual's lights. Twin:
// cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "shading.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;

layout(location = 0) flat in vec4 places[16];
layout(location = 16) flat in vec4 strengths[8];

layout(location = 0) out float picture;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 looks = texelFetch(surface_2, pixel, 0).xyz; // specular, unlit, type
    picture = NO_OBJECT;
    if (looks.z > 0.0) {
        vec4 place = texelFetch(surface_0, pixel, 0);
        vec4 facing = texelFetch(surface_1, pixel, 0);
        vec3 p = place.xyz;
        vec3 n = facing.xyz;
        vec3 v = parameters.orthographic != 0 ? vec3(0.0, 0.0, 1.0) : normalize(parameters.eye - p);
        vec2 response = vec2(0.0);
        for (uint i = 0; i < LIGHTS; ++i) {
            vec2 strength = (i & 1) == 0 ? strengths[i / 2].xy : strengths[i / 2].zw;
            response += light_response(places[i], strength, p, n, v, place.w);
        }
        picture = srgb_encode(looks.y + response.x * facing.w + response.y * looks.x);
    }
}
