#version 450
#extension GL_EXT_samplerless_texture_functions : require
#include "frame.glsl"

layout(set = 0, binding = 1) uniform texture2D depth;
layout(set = 0, binding = 2) uniform texture2D normals;
layout(set = 0, binding = 3) uniform texture2D base_colors;
layout(set = 0, binding = 4) uniform texture2D roughness_metallic;
layout(set = 0, binding = 5) uniform utexture2D ids;

layout(location = 0) out vec4 color;

const vec3 BACKGROUND = vec3(0.012, 0.014, 0.018);
const float AMBIENT = 0.03;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(ids, pixel, 0).r == 0u) {
        color = vec4(BACKGROUND, 1.0);
        return;
    }
    vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(textureSize(depth, 0)) - 1.0;
    vec4 place = world_from_clip * vec4(ndc, texelFetch(depth, pixel, 0).r, 1.0);
    vec3 position = place.xyz / place.w;
    vec3 normal = normalize(texelFetch(normals, pixel, 0).xyz);
    vec3 view = normalize(eye.xyz - position);
    vec3 base = texelFetch(base_colors, pixel, 0).rgb;
    vec2 material = texelFetch(roughness_metallic, pixel, 0).rg;

    // Blinn-Phong, as wide as the material is rough.
    float alpha = material.r * material.r;
    float shininess = clamp(2.0 / (alpha * alpha) - 2.0, 1.0, 4096.0);
    vec3 diffuse = base * (1.0 - material.g);
    vec3 specular = mix(vec3(0.04), base, material.g) * (shininess + 8.0) / 8.0;

    vec3 sum = AMBIENT * base;
    for (int i = 0; i < int(eye.w); i++) {
        vec3 to_light = lights[i].place.xyz - lights[i].place.w * position;
        float distance2 = dot(to_light, to_light);
        vec3 light = to_light * inversesqrt(distance2);
        float falloff = lights[i].place.w > 0.0 ? lights[i].reach2 / distance2 : 1.0;
        float facing = max(dot(normal, light), 0.0);
        float shine = pow(max(dot(normal, normalize(light + view)), 0.0), shininess);
        sum += falloff * facing
            * (lights[i].diffuse * diffuse + lights[i].specular * shine * specular);
    }
    color = vec4(sum, 1.0);
}
