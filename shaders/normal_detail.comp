// Normal detail G_n, first half: for each strip, the sum over SURFACE of the Frobenius length of the
// Sobel pair on the unit normals; a tap outside the object or the picture takes the centre's value.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x = 64) in;

vec3 normal_at(ivec2 pixel, vec3 centre) {
    return inside(pixel) && types[index_of(pixel)] != BACKGROUND
        ? texelFetch(normal_roughness_map, pixel, 0).xyz
        : centre;
}

float detail(ivec2 pixel) {
    vec3 centre = texelFetch(normal_roughness_map, pixel, 0).xyz;
    vec3 n[9];
    for (int k = 0; k < 9; ++k) {
        n[k] = normal_at(pixel + ivec2(k % 3 - 1, k / 3 - 1), centre);
    }
    vec3 gx = ((n[2] - n[0]) + 2.0 * (n[5] - n[3]) + (n[8] - n[6])) / 8.0;
    vec3 gy = ((n[6] - n[0]) + 2.0 * (n[7] - n[1]) + (n[8] - n[2])) / 8.0;
    return sqrt(dot(gx, gx) + dot(gy, gy));
}

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint strip = gl_GlobalInvocationID.y;
    if (x >= size.x) {
        return;
    }
    float sum = 0.0;
    for (uint y = strip * STRIP; y < min((strip + 1u) * STRIP, size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        if (types[index_of(pixel)] == SURFACE) {
            sum += detail(pixel);
        }
    }
    partials[strip * size.x + x] = sum;
}
