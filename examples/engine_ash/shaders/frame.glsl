// What a frame's shaders read: `Uniforms` and `Draw` of renderer.rs.

struct Light {
    vec4 place;     // (position, 1), or (direction towards the light, 0)
    float diffuse;
    float specular;
    float reach2;   // square of the distance at which a point light has its intensity
    float padding;
};

layout(set = 0, binding = 0) uniform Uniforms {
    mat4 clip_from_world;
    mat4 world_from_clip;
    vec4 eye;       // w: number of lights
    Light lights[4];
};

layout(push_constant) uniform Draw {
    mat4 world_from_mesh;
    vec4 base_color;
    float roughness;
    float metallic;
    uint id;
} draw;
