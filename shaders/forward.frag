#version 460
// Forward, second half: the scene itself under an individual's lights. References: src/cpu/visibility/,
// cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"
#define RIG_LOCATION 6
#include "rig.glsl"

layout(location = 0) out float picture;

void main() {
    Surface seen = surface();
    vec3 v = eye.w == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(eye.xyz - position);
    Reflectance looks =
        reflectance(seen.base_color, seen.metallic, seen.roughness, seen.emissive, shading);
    picture = lit(position, seen.normal, v, looks);
}
