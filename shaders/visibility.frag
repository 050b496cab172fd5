#version 460
// Visibility, second half: the colour code, and the surface's position, normal and material.
// Reference: src/cpu/visibility/.
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"
#include "octahedral.glsl"

layout(location = 0) out uint out_code;
layout(location = 1) out vec4 out_position_roughness;
layout(location = 2) out vec4 out_normal_metallic;
layout(location = 3) out vec4 out_base_color;
layout(location = 4) out vec4 out_emissive;

void main() {
    Surface seen = surface();
    out_code = instances[instance].first_polygon + uint(gl_PrimitiveID);
    out_position_roughness = vec4(position, seen.roughness);
    out_normal_metallic = vec4(seen.normal, seen.metallic);
    vec2 face = octahedral_encode(seen.face);
    out_base_color = vec4(seen.base_color, face.x);
    out_emissive = vec4(seen.emissive, face.y);
}
