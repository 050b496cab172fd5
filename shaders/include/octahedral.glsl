// Unit vectors as points of the square -1..1, by way of the octahedron (Cigolle et al. 2014).
// References: octahedral() of src/scene/engine.rs, src/objective/shadows.rs.
#ifndef KLIEG_OCTAHEDRAL
#define KLIEG_OCTAHEDRAL

// 1 where a component is 0.
vec2 octahedral_signs(vec2 v) {
    return vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0);
}

// The point of the octahedron above or below a point of the square.
vec3 octahedron(vec2 e) {
    float z = 1.0 - abs(e.x) - abs(e.y);
    vec2 folded = (1.0 - abs(e.yx)) * octahedral_signs(e);
    return vec3(z >= 0.0 ? e : folded, z);
}

vec3 octahedral_decode(vec2 e) {
    return normalize(octahedron(e));
}

// `d` has any length above 0.
vec2 octahedral_encode(vec3 d) {
    vec2 e = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    return d.z >= 0.0 ? e : (1.0 - abs(e.yx)) * octahedral_signs(e);
}

#endif
