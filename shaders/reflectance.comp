#version 460
// The surface's records from its material: glTF metallic-roughness (glTF 2.0 specification,
// appendix B) as src/lighting/shading.rs simplifies it. Twin: Shading::reflectance.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(parameters.size)))) {
        return;
    }
    vec4 position_roughness = texelFetch(position_roughness_map, pixel, 0);
    vec4 normal_metallic = texelFetch(normal_metallic_map, pixel, 0);
    vec3 base = texelFetch(base_color_map, pixel, 0).rgb;
    vec3 emissive = texelFetch(emissive_map, pixel, 0).rgb;
    float metallic = normal_metallic.w;
    float alpha = position_roughness.w * position_roughness.w;
    // At roughness 0 the quotient would not be finite.
    float shininess = clamp(2.0 / max(alpha * alpha, 1e-30) - 2.0, 1.0, parameters.max_shininess);
    vec3 diffuse = base * (1.0 - metallic);
    vec3 specular = mix(vec3(parameters.dielectric), base, metallic) * ((shininess + 8.0) / 8.0);
    vec3 unlit = base * parameters.ambient + emissive;
    float kind = float(imageLoad(type_map, pixel).x);
    imageStore(record_0, pixel, vec4(position_roughness.xyz, shininess));
    imageStore(record_1, pixel, vec4(normal_metallic.xyz, luminance(diffuse)));
    imageStore(record_2, pixel, vec4(luminance(specular), luminance(unlit), kind, 0.0));
}
