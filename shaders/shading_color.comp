#version 460
// Brightness and irradiance of one object pixel in colour, under the lights of a block of individuals.
// Reference: cpu::population.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "pixels.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint LIGHTS = 1;
// Whether the windows begin with the lights of their blocks.
layout(constant_id = 2) const bool ALIGNED = false;
layout(constant_id = 3) const bool GLTF = false;
layout(constant_id = 4) const uint SHADOW_SIDE = 0;
layout(constant_id = 5) const bool NEAR_LIGHTS = false;

#include "color.glsl"

void main() {
    uint number = gl_GlobalInvocationID.x;
    // The host of a recorded view knows only how many pixels the picture has.
    if (number >= view_statistics.surface + view_statistics.edge) {
        return;
    }
    vec3 p = texelFetch(positions, int(number)).xyz;
    vec3 n = texelFetch(normals, int(number)).xyz;
    vec3 v = to_viewer(p);
    ivec2 pixel = pixel_of(number);
    vec4 diffuse = texelFetch(color_surface, ivec3(pixel, 0), 0);
    vec3 specular = texelFetch(color_surface, ivec3(pixel, 1), 0).rgb;
    ColorReflectance looks = ColorReflectance(diffuse.rgb, specular, diffuse.w, texelFetch(color_surface, ivec3(pixel, 2), 0).rgb);
    vec4 brightness;
    vec4 irradiance;
    [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
        Lit lit = Lit(looks.unlit, 0.0);
        for (uint l = 0; l < LIGHTS; ++l) {
            uint at = i * LIGHTS + l;
            add_light(window[ALIGNED ? at : chunk.light + at], pixel, p, n, v, looks, lit);
        }
        vec2 value = encoded(lit);
        brightness[i] = value.x;
        irradiance[i] = value.y;
    }
    uint at = 2 * chunk.block * stride() + number;
    imageStore(brightness_out, int(at), brightness);
    imageStore(brightness_out, int(at + stride()), irradiance);
}
