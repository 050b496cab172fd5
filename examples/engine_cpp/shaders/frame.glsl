// What renderer.cpp tells the shaders of a frame and of a draw.
#extension GL_EXT_samplerless_texture_functions : require

struct Light {
    vec4 position_radius; // radius 0: the direction towards a directional light
    vec4 intensities;     // diffuse, specular
    mat4 shadow_from_world;
};

layout(set = 0, binding = 0, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 eye;
    Light lights[128];
} frame;

layout(push_constant) uniform Draw {
    mat4 world_from_object;
    vec3 base_color;
    float roughness;
    float metallic;
    uint id;     // of the object, from 1
    uint light;  // number of the light, or of the rig's first light
    uint lights; // of the rig
} draw;
