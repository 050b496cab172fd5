// Gradient of the unit normals. Reference: src/cpu/normal_detail.rs.
#ifndef KLIEG_NORMAL_GRADIENT
#define KLIEG_NORMAL_GRADIENT

#include "layout.glsl"

// Whether a tap lies in the object.
bool has_normal(ivec2 tap) {
    return all(greaterThanEqual(tap, ivec2(0))) && all(lessThan(tap, ivec2(parameters.size)))
        && texelFetch(code_map, tap, 0).r != 0u;
}

// Frobenius length of the Sobel pair on the unit normals; a tap outside the object or the picture takes
// the centre's value.
float normal_gradient(ivec2 pixel) {
    vec3 centre = texelFetch(normal_metallic_map, pixel, 0).xyz;
    vec3 n[9];
    for (int k = 0; k < 9; ++k) {
        ivec2 tap = pixel + ivec2(k % 3 - 1, k / 3 - 1);
        n[k] = has_normal(tap) ? texelFetch(normal_metallic_map, tap, 0).xyz : centre;
    }
    vec3 x = (n[2] - n[0]) + 2.0 * (n[5] - n[3]) + (n[8] - n[6]);
    vec3 y = (n[6] - n[0]) + 2.0 * (n[7] - n[1]) + (n[8] - n[2]);
    return sqrt(dot(x, x) + dot(y, y)) / 8.0;
}

#endif
