#version 460
// Visibility, first half: brings the vertices of an instance into the light frame.
// Reference: src/cpu/visibility/.
#extension GL_GOOGLE_include_directive : require
#include "vertex.glsl"

void main() {
    place(gl_InstanceIndex);
}
