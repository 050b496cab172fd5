#version 460
// Visibility, first half: brings the vertices of an instance into the light frame.
// Twin: src/cpu/visibility.rs.
#extension GL_GOOGLE_include_directive : require
#include "vertex.glsl"

void main() {
    place(gl_InstanceIndex);
}
