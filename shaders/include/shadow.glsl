// Which lights a pixel sees: looked up in the view's shadow table or, of lights that stand within the
// scene, traced. The including shader declares the specialisation constants SHADOW_SIDE and NEAR_LIGHTS and
// color_surface; where the table is not in set 0, it defines the set and the first of five bindings.
// Reference: src/objective/shadows.rs.
#ifndef KLIEG_SHADOW
#define KLIEG_SHADOW

#ifndef OCCLUDERS_SET
#define SHADOW_TABLE_BINDING 10
#define OCCLUDERS_SET 0
#define OCCLUDERS_BINDING 11
#endif

#include "light.glsl"
#include "occluders.glsl"
#include "octahedral.glsl"

// For each object pixel one bit for each of SHADOW_SIDE² directions, set where nothing blocks it. Bit x % 32
// of layer y * SHADOW_WORDS + x / 32.
layout(set = OCCLUDERS_SET, binding = SHADOW_TABLE_BINDING) uniform utexture2DArray shadow_table;

const uint SHADOW_WORDS = (SHADOW_SIDE + 31) / 32; // of a row of the map

// The direction of a vertex of the map, of any length.
vec3 shadow_octahedron(uvec2 at) {
    return octahedron(2.0 * vec2(at) / float(SHADOW_SIDE - 1) - 1.0);
}

// The unit direction of a vertex times the share of the sphere that it stands for, times a constant: vertices
// on the map's border come twice, its corners four times.
vec3 weighted_direction(uvec2 at) {
    vec3 p = shadow_octahedron(at);
    // The centre sees the octahedron's face there under an angle in proportion to 1 / |p|³.
    float squared = dot(p, p);
    bvec2 border = bvec2(at.x == 0 || at.x == SHADOW_SIDE - 1, at.y == 0 || at.y == SHADOW_SIDE - 1);
    return p * ((border.x ? 0.5 : 1.0) * (border.y ? 0.5 : 1.0) / (squared * squared));
}

// A vertex of a pixel's map and the one to the right.
vec2 shadow_bits(ivec2 pixel, uvec2 at) {
    int layer = int(at.y * SHADOW_WORDS + at.x / 32);
    uint word = texelFetch(shadow_table, ivec3(pixel, layer), 0).r >> at.x % 32;
    uint next = word >> 1;
    if (SHADOW_WORDS > 1 && at.x % 32 == 31) {
        next = texelFetch(shadow_table, ivec3(pixel, layer + 1), 0).r;
    }
    return vec2(word & 1, next & 1);
}

// Share of what is seen in the direction `l`, bilinear.
float shadow_lookup(ivec2 pixel, vec3 l) {
    vec2 at = (0.5 * octahedral_encode(l) + 0.5) * float(SHADOW_SIDE - 1);
    uvec2 corner = min(uvec2(at), uvec2(SHADOW_SIDE - 2));
    vec2 share = at - vec2(corner);
    vec2 sides = mix(shadow_bits(pixel, corner), shadow_bits(pixel, corner + uvec2(0, 1)), share.y);
    return mix(sides.x, sides.y, share.x);
}

// Share of the light, towards which the unit vector `l` points, that the surface at p sees.
float light_visibility(Light light, ivec2 pixel, vec3 p, vec3 l) {
    if (NEAR_LIGHTS && light.radius2 > 0.0 && dot(light.position, light.position) < 1.0) {
        vec3 face = texelFetch(color_surface, ivec3(pixel, 3), 0).xyz;
        float distance = length(light.position - p);
        return dot(face, l) > 0.0 && is_blocked(leave(p, face), l, distance) ? 0.0 : 1.0;
    }
    return shadow_lookup(pixel, l);
}

#endif
