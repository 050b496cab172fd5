#version 460
// One pixel of one individual's picture: the stored surface under the individual's lights. Reference:
// cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define RIG_LOCATION 0
#include "rig.glsl"

layout(location = 0) out float picture;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 looks = texelFetch(surface_2, pixel, 0).xyz; // specular, unlit, type
    picture = NO_OBJECT;
    if (looks.z > 0.0) {
        vec4 place = texelFetch(surface_0, pixel, 0);
        vec4 facing = texelFetch(surface_1, pixel, 0);
        vec3 v = to_viewer(place.xyz);
        picture = lit(place.xyz, facing.xyz, v, Reflectance(facing.w, looks.x, place.w, looks.y));
    }
}
