#version 460
// Forward in colour, second half: the scene itself under an individual's lights. References:
// src/cpu/visibility/, cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;
layout(constant_id = 1) const uint BRDF = 0;
const bool GLTF = BRDF > 0;
layout(constant_id = 2) const uint SHADOW_SIDE = 0;
layout(constant_id = 3) const bool NEAR_LIGHTS = false;

#define SHADOW_TABLE_BINDING 2
#define OCCLUDERS_SET 2
#define OCCLUDERS_BINDING 3

#extension GL_EXT_samplerless_texture_functions : require
layout(set = 2, binding = 1) uniform texture2DArray color_surface; // see layout.glsl

#include "color_reflectance.glsl"

layout(set = 2, binding = 0, std430) readonly buffer Lights { Light lights[]; };

layout(location = 6) flat in uint rig;
layout(location = 0) out vec2 picture;

void main() {
    Surface seen = surface();
    vec3 v = eye.w == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(eye.xyz - position);
    // The table and the ambient occlusion are those of the visible surface; it draws over all others.
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 constants = shading;
    if (SHADOW_SIDE > 0) {
        constants.x *= texelFetch(color_surface, ivec3(pixel, 3), 0).w;
    }
    float n_v = max(dot(seen.normal, v), 0.0);
    ColorReflectance looks = color_reflectance(
        seen.base_color, seen.metallic, seen.roughness, seen.emissive, n_v, constants);
    Lit lit = Lit(looks.unlit, 0.0);
    for (uint i = 0; i < LIGHTS; ++i) {
        add_light(lights[rig + i], pixel, position, seen.normal, v, looks, lit);
    }
    picture = encoded(lit);
}
