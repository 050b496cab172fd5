#version 460
// Brightness of one object pixel under the lights of a block of individuals. What the individuals
// share is read and computed once. Reference: cpu::population.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pixels.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint LIGHTS = 1;
// Whether the windows begin with the lights of their blocks.
layout(constant_id = 2) const bool ALIGNED = false;

void main() {
    // Read before any branch: behind one, software devices read for each lane what all lanes share.
    Light rigs[BLOCK * LIGHTS];
    [[unroll]] for (uint k = 0; k < BLOCK * LIGHTS; ++k) {
        rigs[k] = window[ALIGNED ? k : chunk.light + k];
    }
    uint number = gl_GlobalInvocationID.x;
    // The host of a recorded view knows only how many pixels the picture has.
    if (gl_WorkGroupID.x * gl_WorkGroupSize.x >= view_statistics.surface + view_statistics.edge) {
        return;
    }
    vec4 place = texelFetch(positions, int(number));
    vec4 facing = texelFetch(normals, int(number));
    vec2 look = texelFetch(looks, int(number)).xy;
    vec3 p = place.xyz;
    vec3 n = facing.xyz;
    vec3 v = to_viewer(p);
    vec4 result;
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        vec2 response = vec2(0.0);
        [[unroll]] for (uint l = 0; l < LIGHTS; ++l) {
            Light light = rigs[i * LIGHTS + l];
            response += light_response(vec4(light.position, light.radius2),
                vec2(light.diffuse, light.specular), p, n, v, place.w);
        }
        result[i] = srgb_encode(look.y + response.x * facing.w + response.y * look.x);
    }
    imageStore(brightness_out, int(chunk.block * stride() + number), result);
}
