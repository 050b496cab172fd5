#version 460
// The surface's records for shading in colour, and for what more is measured than the brightness.
// References: Shading::reflectance, cpu::normal_detail.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "normal_gradient.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const bool GLTF = false;

#include "color.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(parameters.size)))) {
        return;
    }
    float roughness = texelFetch(position_roughness_map, pixel, 0).w;
    float metallic = texelFetch(normal_metallic_map, pixel, 0).w;
    vec3 base = texelFetch(base_color_map, pixel, 0).rgb;
    vec3 emissive = texelFetch(emissive_map, pixel, 0).rgb;
    ColorReflectance looks = color_reflectance(base, metallic, roughness, emissive, shading_constants());
    bool surface = imageLoad(type_map, pixel).x == SURFACE;
    float gradient = surface ? normal_gradient(pixel) : 0.0;
    imageStore(color_records, ivec3(pixel, 0), vec4(looks.diffuse, looks.lobe));
    imageStore(color_records, ivec3(pixel, 1), vec4(looks.specular, gradient));
    imageStore(color_records, ivec3(pixel, 2), vec4(looks.unlit, NO_TARGET));
}
