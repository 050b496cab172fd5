#version 460
// One full-screen triangle for each individual, in the layer of its own picture. The lights go
// along as flat varyings, so that no fragment reads them from memory.
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "layout.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;

layout(location = 0) flat out vec4 places[16];
layout(location = 16) flat out vec4 strengths[8]; // two lights each

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
    gl_Layer = gl_InstanceIndex;
    uint first_light = (chunk.first + gl_InstanceIndex) * LIGHTS;
    for (uint i = 0; i < LIGHTS; i += 2) {
        Light one = lights[first_light + i];
        places[i] = vec4(one.position, one.radius2);
        strengths[i / 2] = vec4(one.diffuse, one.specular, 0.0, 0.0);
        if (i + 1 < LIGHTS) {
            Light other = lights[first_light + i + 1];
            places[i + 1] = vec4(other.position, other.radius2);
            strengths[i / 2].zw = vec2(other.diffuse, other.specular);
        }
    }
}
