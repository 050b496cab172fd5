#version 460
// The surface's records from its material. Reference: Shading::reflectance.
#extension GL_GOOGLE_include_directive : require
#include "records.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(parameters.size)))) {
        return;
    }
    vec4 position_roughness = texelFetch(position_roughness_map, pixel, 0);
    vec4 normal_metallic = texelFetch(normal_metallic_map, pixel, 0);
    vec3 base = base_color_of(pixel);
    vec3 emissive = emissive_of(pixel);
    Reflectance looks = reflectance(
        base, normal_metallic.w, position_roughness.w, emissive, shading_constants());
    float kind = float(type_at(pixel));
    imageStore(record_0, pixel, vec4(position_roughness.xyz, looks.shininess));
    imageStore(record_1, pixel, vec4(normal_metallic.xyz, looks.diffuse));
    imageStore(record_2, pixel, vec4(looks.specular, looks.unlit, kind, 0.0));
}
