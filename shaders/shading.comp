#version 460
// Brightness of one object pixel under the lights of a block of individuals. What the individuals
// share is read and computed once. Twin: cpu::population.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pixels.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint LIGHTS = 1;

void main() {
    uint number = gl_GlobalInvocationID.x;
    // The host of a recorded view knows only how many pixels the picture has.
    if (gl_WorkGroupID.x * gl_WorkGroupSize.x >= view_statistics.surface + view_statistics.edge) {
        return;
    }
    vec4 place = positions[number];
    vec4 facing = normals[number];
    vec2 look = looks[number];
    vec3 p = place.xyz;
    vec3 n = facing.xyz;
    vec3 v = to_viewer(p);
    vec4 result;
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        vec2 response = vec2(0.0);
        [[unroll]] for (uint l = 0; l < LIGHTS; ++l) {
            Light light = window[chunk.light + i * LIGHTS + l];
            response += light_response(vec4(light.position, light.radius2),
                vec2(light.diffuse, light.specular), p, n, v, place.w);
        }
        result[i] = srgb_encode(look.y + response.x * facing.w + response.y * look.x);
    }
    brightness[chunk.block * positions.length() + number] = result;
}
