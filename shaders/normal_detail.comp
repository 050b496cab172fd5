#version 460
// Normal detail G_n, first half: for each strip, the sum over SURFACE of the Frobenius length of the
// Sobel pair on the unit normals; a tap outside the object or the picture takes the centre's value.
// Reference: src/cpu/normal_detail.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

float detail(ivec2 pixel) {
    vec3 centre = texelFetch(normal_metallic_map, pixel, 0).xyz;
    vec3 n[9];
    for (int k = 0; k < 9; ++k) {
        ivec2 tap = pixel + ivec2(k % 3 - 1, k / 3 - 1);
        n[k] = inside(tap) && is_object(tap)
            ? texelFetch(normal_metallic_map, tap, 0).xyz
            : centre;
    }
    vec3 x = (n[2] - n[0]) + 2.0 * (n[5] - n[3]) + (n[8] - n[6]);
    vec3 y = (n[6] - n[0]) + 2.0 * (n[7] - n[1]) + (n[8] - n[2]);
    return sqrt(dot(x, x) + dot(y, y)) / 8.0;
}

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint strip = gl_GlobalInvocationID.y;
    if (x >= parameters.size.x) {
        return;
    }
    float sum = 0.0;
    for (uint y = strip * STRIP; y < min((strip + 1u) * STRIP, parameters.size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        if (imageLoad(type_map, pixel).x == SURFACE) {
            sum += detail(pixel);
        }
    }
    partials[strip * parameters.size.x + x] = sum;
}
