#version 460
// One full-screen triangle for each individual, in the layer of its own picture.
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "layout.glsl"

layout(location = 0) flat out uint individual;

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
    gl_Layer = gl_InstanceIndex;
    individual = chunk.first + gl_InstanceIndex;
}
