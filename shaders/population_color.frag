#version 460
// One pixel of one individual's picture in colour: the stored surface under the individual's lights.
// Reference: cpu::population.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;
layout(constant_id = 1) const bool GLTF = false;
layout(constant_id = 2) const uint SHADOW_SIDE = 0;
layout(constant_id = 3) const bool NEAR_LIGHTS = false;

#include "color.glsl"

layout(location = 0) flat in uint individual;
layout(location = 0) out vec2 picture;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    picture = vec2(NO_OBJECT, 0.0);
    if (texelFetch(surface_2, pixel, 0).z > 0.0) {
        vec3 p = texelFetch(surface_0, pixel, 0).xyz;
        vec3 n = texelFetch(surface_1, pixel, 0).xyz;
        vec4 diffuse = texelFetch(color_surface, ivec3(pixel, 0), 0);
        vec3 specular = texelFetch(color_surface, ivec3(pixel, 1), 0).rgb;
        ColorReflectance looks = ColorReflectance(diffuse.rgb, specular, diffuse.w, texelFetch(color_surface, ivec3(pixel, 2), 0).rgb);
        Lit lit = Lit(looks.unlit, 0.0);
        vec3 v = to_viewer(p);
        for (uint i = 0; i < LIGHTS; ++i) {
            add_light(lights[individual * LIGHTS + i], pixel, p, n, v, looks, lit);
        }
        picture = encoded(lit);
    }
}
