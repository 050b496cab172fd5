// What the two shaders of the visibility stage share; the Rust side is src/gpu/layout/.

#include "constants.glsl"

struct InstanceRecord {
    mat4 frame_from_mesh;
    mat3 normal_from_mesh;  // a positive multiple of the linear part's inverse transpose
    uint first_polygon;
    uint material;
    uint mirrored;          // 1 where the transform turns the winding round
    uint padding;
};

// A material's use of a texture: the rows of the 2x3 transform, the coordinate set in u.w.
struct TextureUse {
    vec4 u;
    vec4 v;
};

struct MaterialRecord {
    vec4 base_color;
    vec4 emissive_normal_scale; // w: scale of the normal texture's x and y
    float metallic;
    float roughness;
    float alpha_cutoff;
    uint flags;
    TextureUse textures[MATERIAL_TEXTURES]; // base colour, metallic-roughness, normal, emissive
};

layout(set = 0, binding = 0, std430) readonly buffer Instances { InstanceRecord instances[]; };
layout(set = 0, binding = 1, std430) readonly buffer Materials { MaterialRecord materials[]; };

layout(push_constant) uniform Camera {
    mat4 clip_from_frame;
    vec4 eye;               // w: 1 where all view rays are parallel
    // For populations alone.
    vec3 shading;           // ambient, dielectric, max_shininess
    uint first_light;
    uint first_instance;    // of a draw
    uint instances_of_picture; // of a draw
};

// v at unit length, or `other` where v has none.
vec3 unit_or(vec3 v, vec3 other) {
    float squared = dot(v, v);
    return squared > 0.0 ? v / sqrt(squared) : other;
}
