#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out flat mat4 world_from_clip;

// One triangle that covers the picture.
void main() {
    world_from_clip = inverse(frame.clip_from_world);
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
