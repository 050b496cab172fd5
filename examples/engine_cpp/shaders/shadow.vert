#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 position;

void main() {
    vec4 world = draw.world_from_object * vec4(position, 1.0);
    gl_Position = frame.lights[draw.light].shadow_from_world * world;
}
