#version 460
// Forward in colour, second half: the scene itself under an individual's lights. References:
// src/cpu/visibility/, cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;
layout(constant_id = 1) const bool GLTF = false;

#include "color.glsl"

layout(set = 2, binding = 0, std430) readonly buffer Lights { Light lights[]; };

layout(location = 6) flat in uint rig;
layout(location = 0) out vec2 picture;

void main() {
    Surface seen = surface();
    vec3 v = eye.w == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(eye.xyz - position);
    ColorReflectance looks = color_reflectance(seen.base_color, seen.metallic, seen.roughness, seen.emissive, shading);
    Lit lit = Lit(looks.unlit, 0.0);
    for (uint i = 0; i < LIGHTS; ++i) {
        add_light(lights[rig + i], position, seen.normal, v, looks, lit);
    }
    picture = encoded(lit);
}
