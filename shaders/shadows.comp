#version 460
// The view's shadow table: which directions each object pixel sees. An invocation has one row of one pixel's
// octahedral map. Reference: src/cpu/shadows/.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint SHADOW_SIDE = 3;
const bool NEAR_LIGHTS = false;

#include "shadow.glsl"

// The table, written.
layout(set = 1, binding = 0, r32ui) uniform writeonly uimage2DArray shadow_words;

void main() {
    // A submission has some rows of the picture alone, from chunk.first on.
    ivec2 pixel = ivec2(gl_GlobalInvocationID.x, chunk.first + gl_GlobalInvocationID.y);
    if (any(greaterThanEqual(pixel, ivec2(parameters.size)))
        || texelFetch(code_map, pixel, 0).r == 0u) {
        return;
    }
    uint y = gl_GlobalInvocationID.z;
    vec3 face = face_of(pixel);
    vec3 from = leave(texelFetch(position_roughness_map, pixel, 0).xyz, face);
    uint word = 0;
    for (uint x = 0; x < SHADOW_SIDE; ++x) {
        vec3 direction = normalize(shadow_octahedron(uvec2(x, y)));
        bool seen = dot(face, direction) <= 0.0 || !is_blocked(from, direction, OUT_OF_SCENE);
        word |= seen ? 1u << x % 32 : 0u;
        if (x % 32 == 31 || x + 1 == SHADOW_SIDE) {
            imageStore(shadow_words, ivec3(pixel, y * SHADOW_WORDS + x / 32), uvec4(word));
            word = 0;
        }
    }
}
