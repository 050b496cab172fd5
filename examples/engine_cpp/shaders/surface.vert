#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 world_normal;

void main() {
    world_normal = mat3(draw.world_from_object) * normal; // no object is scaled unevenly
    gl_Position = frame.clip_from_world * draw.world_from_object * vec4(position, 1.0);
}
