#version 460
// Forward, first half: every instance once for each individual, in the layer of its picture.
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "vertex.glsl"
#define RIG_OUT
#define RIG_LOCATION 6
#include "rig.glsl"

layout(set = 2, binding = 0, std430) readonly buffer Lights { Light lights[]; };

void main() {
    uint individual = gl_InstanceIndex / instances_of_picture;
    place(first_instance + gl_InstanceIndex % instances_of_picture);
    gl_Layer = int(individual);
    for (uint i = 0; i < LIGHTS; ++i) {
        pass_light(i, lights[first_light + individual * LIGHTS + i]);
    }
}
