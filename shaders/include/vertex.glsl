// What the vertex shaders of the scene's geometry share: an instance's vertex in the light frame.
// Reference: src/cpu/visibility/.
#ifndef KLIEG_VERTEX
#define KLIEG_VERTEX

#include "visibility.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec4 in_uv;
layout(location = 4) in vec4 in_color;

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 tangent;
layout(location = 3) out vec4 uv;
layout(location = 4) out vec4 color;
layout(location = 5) flat out uint instance;

// Writes the vertex's position and outputs.
void place(uint of_instance) {
    InstanceRecord record = instances[of_instance];
    // Summed column by column as the CPU reference does: the depth test hangs on the last bit.
    mat4 m = record.frame_from_mesh;
    precise vec4 p = m[0] * in_position.x + m[1] * in_position.y + m[2] * in_position.z + m[3];
    precise vec4 clip = clip_from_frame[0] * p.x + clip_from_frame[1] * p.y
        + clip_from_frame[2] * p.z + clip_from_frame[3];
    gl_Position = clip;
    position = p.xyz;
    normal = unit_or(record.normal_from_mesh * in_normal, vec3(0.0));
    tangent = vec4(unit_or(mat3(m) * in_tangent.xyz, vec3(0.0)), in_tangent.w);
    uv = in_uv;
    color = in_color;
    instance = of_instance;
}

#endif
