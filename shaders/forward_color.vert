#version 460
// Forward in colour, first half: every instance once for each individual, in the layer of its picture.
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "vertex.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;

layout(location = 6) flat out uint rig; // its first light

void main() {
    uint individual = gl_InstanceIndex / instances_of_picture;
    place(first_instance + gl_InstanceIndex % instances_of_picture);
    gl_Layer = int(individual);
    rig = first_light + individual * LIGHTS;
}
