#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 0) out vec4 normal;
layout(location = 1) out vec4 base_color;
layout(location = 2) out vec2 roughness_metallic;
layout(location = 3) out uint id;

void main() {
    normal = vec4(normalize(world_normal), 0.0);
    base_color = vec4(draw.base_color, 1.0);
    roughness_metallic = vec2(draw.roughness, draw.metallic);
    id = draw.id;
}
