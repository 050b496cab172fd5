#version 460
// The engine's own shading: a GGX lobe over a Lambert one, shadow maps, light from the sky.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform texture2D normal_image;
layout(set = 0, binding = 3) uniform texture2D base_color_image;
layout(set = 0, binding = 4) uniform texture2D roughness_metallic_image;
layout(set = 0, binding = 5) uniform sampler2DArrayShadow shadow_maps;

layout(location = 0) in flat mat4 world_from_clip;
layout(location = 0) out vec4 picture;

// Share of a light that reaches `p`, 0..1, over 3 x 3 texels of its shadow map.
float visibility(uint k, vec3 p, vec3 n) {
    vec4 clip = frame.lights[draw.light + k].shadow_from_world * vec4(p + 0.03 * n, 1.0);
    vec3 at = clip.xyz / clip.w;
    float sum = 0.0;
    for (int i = 0; i < 9; ++i) {
        vec2 texel = vec2(i % 3 - 1, i / 3 - 1) / vec2(textureSize(shadow_maps, 0).xy);
        sum += texture(shadow_maps, vec4(0.5 + 0.5 * at.xy + texel, k, at.z));
    }
    return sum / 9.0;
}

// Cook and Torrance's lobe with the GGX distribution, divided by that of a Lambert surface.
vec3 lobe(vec3 f0, float roughness, vec3 n, vec3 l, vec3 v) {
    vec3 h = normalize(l + v);
    float n_l = dot(n, l), n_v = max(dot(n, v), 1e-3), n_h = max(dot(n, h), 0.0);
    float a2 = pow(max(roughness, 0.05), 4.0);
    float bottom = n_h * n_h * (a2 - 1.0) + 1.0;
    float in_light = n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    float in_view = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2);
    float seen = 0.5 / (in_light + in_view);
    vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(h, v), 0.0), 5.0);
    return a2 / (bottom * bottom) * seen * fresnel;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_image, pixel, 0).r;
    if (depth == 0.0) {
        picture = vec4(0.05, 0.06, 0.08, 1.0);
        return;
    }
    vec2 at = 2.0 * gl_FragCoord.xy / textureSize(depth_image, 0) - 1.0;
    vec4 world = world_from_clip * vec4(at, depth, 1.0);
    vec3 p = world.xyz / world.w;
    vec3 n = normalize(texelFetch(normal_image, pixel, 0).xyz);
    vec3 v = normalize(frame.eye.xyz - p);
    vec3 base = texelFetch(base_color_image, pixel, 0).rgb;
    vec2 rm = texelFetch(roughness_metallic_image, pixel, 0).rg;
    vec3 diffuse = base * (1.0 - rm.y), f0 = mix(vec3(0.04), base, rm.y);

    vec3 color = base * mix(0.02, 0.06, 0.5 + 0.5 * n.y);
    for (uint k = 0; k < draw.lights; ++k) {
        Light light = frame.lights[draw.light + k];
        float radius = light.position_radius.w;
        vec3 to = light.position_radius.xyz - (radius > 0.0 ? p : vec3(0.0));
        vec3 l = normalize(to);
        float n_l = dot(n, l);
        if (n_l <= 0.0) {
            continue;
        }
        float falloff = radius > 0.0 ? radius * radius / dot(to, to) : 1.0;
        vec3 specular = lobe(f0, rm.x, n, l, v);
        vec3 reflected = light.intensities.x * diffuse + light.intensities.y * specular;
        color += falloff * n_l * visibility(k, p, n) * reflected;
    }
    picture = vec4(color, 1.0);
}
