#version 450
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

layout(location = 0) out vec3 world_normal;

void main() {
    gl_Position = clip_from_world * (draw.world_from_mesh * vec4(position, 1.0));
    // Rotations and even scales alone, so that the matrix does for normals too.
    world_normal = mat3(draw.world_from_mesh) * normal;
}
