#version 460
// The surface's records for shading in colour, and for what more is measured than the brightness.
// References: Shading::reflectance, cpu::normal_detail.
#extension GL_GOOGLE_include_directive : require
#include "records.glsl"
#include "normal_gradient.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint BRDF = 0;
const bool GLTF = BRDF > 0;
layout(constant_id = 3) const uint SHADOW_SIDE = 0;
const bool NEAR_LIGHTS = false;

#include "color_reflectance.glsl"

// Ambient occlusion: the cosine-weighted share of the directions above the unit normal `n` from which light
// comes to a pixel.
float openness(ivec2 pixel, vec3 n) {
    float open = 0.0;
    float all = 0.0;
    for (uint y = 0; y < SHADOW_SIDE; ++y) {
        uint word = 0;
        for (uint x = 0; x < SHADOW_SIDE; ++x) {
            if (x % 32 == 0) {
                word = texelFetch(shadow_table, ivec3(pixel, y * SHADOW_WORDS + x / 32), 0).r;
            }
            float weight = max(dot(n, weighted_direction(uvec2(x, y))), 0.0);
            all += weight;
            open += (word >> x % 32 & 1) != 0 ? weight : 0.0;
        }
    }
    return open / all;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(parameters.size)))) {
        return;
    }
    float roughness = texelFetch(position_roughness_map, pixel, 0).w;
    float metallic = texelFetch(normal_metallic_map, pixel, 0).w;
    vec3 base = base_color_of(pixel);
    vec3 emissive = emissive_of(pixel);
    vec3 constants = shading_constants();
    if (SHADOW_SIDE > 0 && texelFetch(code_map, pixel, 0).r != 0u) {
        float open = openness(pixel, texelFetch(normal_metallic_map, pixel, 0).xyz);
        constants.x *= open;
        imageStore(color_records, ivec3(pixel, 3), vec4(face_of(pixel), open));
    }
    vec3 p = texelFetch(position_roughness_map, pixel, 0).xyz;
    float n_v = max(dot(texelFetch(normal_metallic_map, pixel, 0).xyz, to_viewer(p)), 0.0);
    ColorReflectance looks =
        color_reflectance(base, metallic, roughness, emissive, n_v, constants);
    bool surface = type_at(pixel) == SURFACE;
    float gradient = surface ? normal_gradient(pixel) : 0.0;
    imageStore(color_records, ivec3(pixel, 0), vec4(looks.diffuse, looks.lobe));
    imageStore(color_records, ivec3(pixel, 1), vec4(looks.specular, gradient));
    imageStore(color_records, ivec3(pixel, 2), vec4(looks.unlit, NO_TARGET));
}
