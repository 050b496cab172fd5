// Rays through the triangles of a scene, light frame. The including shader defines OCCLUDERS_SET and
// OCCLUDERS_BINDING, the first of four bindings. Reference: src/scene/occluders/.
#ifndef KLIEG_OCCLUDERS
#define KLIEG_OCCLUDERS

#include "constants.glsl"

// Nodes stand in depth-first order, so that a walk needs no stack.
struct Node {
    vec3 low;
    uint skip; // the node after this one and all below it
    vec3 high;
    uint triangles; // of a leaf: the first, and how many in the upper bits; INNER_NODE of others
};

struct Triangle {
    vec3 corner;
    uint opacity; // where its cells begin, or OPAQUE
    vec3 edge1;
    uint padding1;
    vec3 edge2;
    uint padding2;
};

layout(set = OCCLUDERS_SET, binding = OCCLUDERS_BINDING, std430) readonly buffer Nodes { Node nodes[]; };
layout(set = OCCLUDERS_SET, binding = OCCLUDERS_BINDING + 1, std430) readonly buffer Triangles {
    Triangle triangles[];
};
// Of each triangle with an alpha mask: cells along an edge, then a bit for each half of a cell.
layout(set = OCCLUDERS_SET, binding = OCCLUDERS_BINDING + 2, std430) readonly buffer Opacity {
    uint opacity[];
};

// Their own frame from the light frame. It may scale: distances stay those of the light frame.
layout(set = OCCLUDERS_SET, binding = OCCLUDERS_BINDING + 3, std140) uniform OccludersFrame {
    mat4 occluders_from_frame;
};

// Node::INNER, and how the triangles of a leaf are told.
const uint INNER_NODE = 0xffffffffu;
const uint LEAF_FIRST_BITS = 27;
const uint LEAF_FIRST_MASK = (1u << LEAF_FIRST_BITS) - 1;

// A distance that leads out of the scene.
const float OUT_OF_SCENE = 1e30;

// Where rays from a point on a polygon start; `face` is the unit normal of the side that is seen.
vec3 leave(vec3 p, vec3 face) {
    return p + face * SHADOW_OFFSET;
}

// Whether the half cell at the barycentric coordinates u and v blocks.
bool is_opaque(uint cells, float u, float v) {
    uint n = opacity[cells];
    float x = u * float(n);
    float y = v * float(n);
    uint i = min(uint(x), n - 1);
    uint j = min(uint(y), n - 1);
    bool beyond = (x - float(i)) + (y - float(j)) > 1.0;
    uint bit = 2 * (i * n + j) + (beyond ? 1 : 0);
    return (opacity[cells + 1 + bit / 32] >> bit % 32 & 1) != 0;
}

// Möller and Trumbore (1997), both sides; coordinates and distance are times the determinant.
bool hits(Triangle triangle, vec3 from, vec3 direction, float distance) {
    vec3 p = cross(direction, triangle.edge2);
    float determinant = dot(triangle.edge1, p);
    if (determinant == 0.0) {
        return false;
    }
    vec3 s = (determinant < 0.0 ? -1.0 : 1.0) * (from - triangle.corner);
    determinant = abs(determinant);
    float u = dot(s, p);
    float v = dot(s, cross(triangle.edge1, direction));
    float t = dot(s, cross(triangle.edge1, triangle.edge2));
    bool inside =
        u >= 0.0 && v >= 0.0 && u + v <= determinant && t > 0.0 && t < distance * determinant;
    return inside
        && (triangle.opacity == OPAQUE
            || is_opaque(triangle.opacity, u / determinant, v / determinant));
}

// The reciprocal, finite, so that no product of it is not a number.
float finite_inverse(float component) {
    return 1.0 / (abs(component) < 1e-12 ? (component < 0.0 ? -1e-12 : 1e-12) : component);
}

bool reaches(Node node, vec3 from, vec3 inverse, float distance) {
    vec3 low = (node.low - from) * inverse;
    vec3 high = (node.high - from) * inverse;
    vec3 nearer = min(low, high);
    vec3 farther = max(low, high);
    float enter = max(nearer.x, max(nearer.y, nearer.z));
    // Rounding must not lose a hit on the border of a box.
    float leaves = min(farther.x, min(farther.y, farther.z)) * (1.0 + 4.0 * 1.1920929e-7);
    return enter <= leaves && leaves >= 0.0 && enter < distance;
}

// Whether anything blocks the way along the unit vector `direction` before `distance`.
bool is_blocked(vec3 from, vec3 direction, float distance) {
    from = (occluders_from_frame * vec4(from, 1.0)).xyz;
    direction = mat3(occluders_from_frame) * direction;
    vec3 inverse = vec3(
        finite_inverse(direction.x), finite_inverse(direction.y), finite_inverse(direction.z));
    uint at = 0;
    while (at < nodes.length()) {
        Node node = nodes[at];
        if (!reaches(node, from, inverse, distance)) {
            at = node.skip;
            continue;
        }
        at += 1;
        if (node.triangles == INNER_NODE) {
            continue;
        }
        uint first = node.triangles & LEAF_FIRST_MASK;
        uint end = first + (node.triangles >> LEAF_FIRST_BITS) + 1;
        for (uint i = first; i < end; ++i) {
            if (hits(triangles[i], from, direction, distance)) {
                return true;
            }
        }
    }
    return false;
}

#endif
