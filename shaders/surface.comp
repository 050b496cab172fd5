#version 460
// Surface: what an engine has drawn, as the visibility draw would have left it.
// Reference: src/cpu/surface.rs.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "constants.glsl"
#include "octahedral.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

layout(set = 0, binding = 0) uniform texture2D depth_image;
layout(set = 0, binding = 1) uniform texture2D normal_image;
layout(set = 0, binding = 2) uniform texture2D base_color_image;
layout(set = 0, binding = 3) uniform texture2D roughness_metallic_image;
layout(set = 0, binding = 4) uniform texture2D emissive_image;
layout(set = 0, binding = 5) uniform utexture2D id_image;

layout(set = 0, binding = 6, r32ui) uniform writeonly uimage2D code_map;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D position_roughness_map;
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D normal_metallic_map;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2DArray material_map; // see layout.glsl

layout(set = 0, binding = 10, std140) uniform EngineSurface {
    mat4 frame_from_clip;
    mat4 frame_from_normals; // a rotation
    vec4 eye; // the viewer in the light frame; w: 1 where all view rays are parallel
    vec4 base_color_roughness; // where no image tells
    float metallic; // where no image tells
    float cleared_depth; // of the background
    uint flags; // HAS_NORMAL to BASE_COLOR_ENCODED
    uint channels; // of roughness, and of metallic factor times 4
    uvec2 size; // width and height, pixels
    uvec2 padding;
} engine;

bool has(uint flag) {
    return (engine.flags & flag) != 0u;
}

bool is_object(ivec2 pixel) {
    return has(HAS_IDS) ? texelFetch(id_image, pixel, 0).r != 0u
                        : texelFetch(depth_image, pixel, 0).r != engine.cleared_depth;
}

// Position in the light frame of what is seen in a pixel.
vec3 position_of(ivec2 pixel) {
    vec2 at = 2.0 * (vec2(pixel) + 0.5) / vec2(engine.size) - 1.0;
    at.y = has(FLIPPED) ? -at.y : at.y;
    vec4 p = engine.frame_from_clip * vec4(at, texelFetch(depth_image, pixel, 0).r, 1.0);
    return p.xyz / p.w;
}

vec3 to_viewer(vec3 p) {
    return engine.eye.w == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(engine.eye.xyz - p);
}

// The step along an axis to the neighbour whose depth is nearer, or none.
vec3 tangent(ivec2 pixel, ivec2 axis, vec3 p) {
    vec3 steps[2];
    float lengths[2];
    for (int k = 0; k < 2; ++k) {
        ivec2 tap = pixel + (2 * k - 1) * axis;
        bool inside = all(greaterThanEqual(tap, ivec2(0))) && all(lessThan(tap, ivec2(engine.size)));
        bool found = inside && is_object(tap);
        steps[k] = found ? float(2 * k - 1) * (position_of(tap) - p) : vec3(0.0);
        lengths[k] = found ? abs(steps[k].z) : 3.4e38;
    }
    return lengths[0] < lengths[1] ? steps[0] : steps[1];
}

// Unit normal of what lies between the pixel and its neighbours, turned to the viewer, `v`.
vec3 face_of(ivec2 pixel, vec3 p, vec3 v) {
    vec3 n = cross(tangent(pixel, ivec2(1, 0), p), tangent(pixel, ivec2(0, 1), p));
    n = dot(n, v) < 0.0 ? -n : n;
    float squared = dot(n, n);
    return squared > 0.0 ? n / sqrt(squared) : v;
}

// Unit normal turned to the viewer, `v`; `face` is that of the neighbours.
vec3 normal_of(ivec2 pixel, vec3 v, vec3 face) {
    if (!has(HAS_NORMAL)) {
        return face;
    }
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;
    n = has(NORMAL_UNSIGNED) ? 2.0 * n - 1.0 : n;
    n = has(NORMAL_OCTAHEDRAL) ? octahedral_decode(n.xy) : n;
    n = mat3(engine.frame_from_normals) * n;
    float squared = dot(n, n);
    n = squared > 0.0 ? n / sqrt(squared) : v;
    return n - 2.0 * min(dot(n, v), 0.0) * v;
}

vec3 base_color_of(ivec2 pixel) {
    if (!has(HAS_BASE_COLOR)) {
        return engine.base_color_roughness.rgb;
    }
    vec3 color = texelFetch(base_color_image, pixel, 0).rgb;
    return has(BASE_COLOR_ENCODED)
        ? vec3(srgb_decode(color.r), srgb_decode(color.g), srgb_decode(color.b))
        : color;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(engine.size)))) {
        return;
    }
    vec3 p = position_of(pixel);
    bool object = is_object(pixel) && !any(isnan(p)) && !any(isinf(p));
    if (!object) {
        imageStore(code_map, pixel, uvec4(0));
        imageStore(position_roughness_map, pixel, vec4(0.0));
        imageStore(normal_metallic_map, pixel, vec4(0.0));
        imageStore(material_map, ivec3(pixel, 0), vec4(0.0));
        imageStore(material_map, ivec3(pixel, 1), vec4(0.0));
        return;
    }
    float roughness = engine.base_color_roughness.w;
    float metallic = engine.metallic;
    if (has(HAS_ROUGHNESS_METALLIC)) {
        vec4 texel = texelFetch(roughness_metallic_image, pixel, 0);
        roughness = texel[engine.channels & 3u];
        metallic = texel[engine.channels >> 2u & 3u];
    }
    vec3 emissive = has(HAS_EMISSIVE) ? texelFetch(emissive_image, pixel, 0).rgb : vec3(0.0);
    vec3 v = to_viewer(p);
    vec3 face = face_of(pixel, p, v);
    vec3 n = normal_of(pixel, v, face);
    vec2 face_code = octahedral_encode(face);
    uint code = has(HAS_IDS) ? texelFetch(id_image, pixel, 0).r : 1u;
    imageStore(code_map, pixel, uvec4(code));
    imageStore(position_roughness_map, pixel, vec4(p, clamp(roughness, 0.0, 1.0)));
    imageStore(normal_metallic_map, pixel, vec4(n, clamp(metallic, 0.0, 1.0)));
    imageStore(material_map, ivec3(pixel, 0), vec4(base_color_of(pixel), face_code.x));
    imageStore(material_map, ivec3(pixel, 1), vec4(emissive, face_code.y));
}
