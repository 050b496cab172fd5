#version 460
// The shape that a view shows, first half: for each strip, the sums over SURFACE of |grad n| and of its
// weight, and those over the object of the normals' x and y, their products and the base colour's
// luminance. References: src/cpu/normal_detail.rs, src/cpu/shape.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"
#include "normal_gradient.glsl"
#include "shading.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;

void main() {
    uint x = gl_GlobalInvocationID.x;
    uint strip = gl_GlobalInvocationID.y;
    if (x >= parameters.size.x) {
        return;
    }
    ShapePart part = ShapePart(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (uint y = strip * STRIP; y < min((strip + 1u) * STRIP, parameters.size.y); ++y) {
        ivec2 pixel = ivec2(x, y);
        uint kind = type_at(pixel);
        if (kind == BACKGROUND) {
            continue;
        }
        if (kind == SURFACE) {
            float gradient = normal_gradient(pixel);
            part.gradient += gradient;
            part.weight += min(gradient, DETAIL_MOST);
        }
        vec2 n = texelFetch(normal_metallic_map, pixel, 0).xy;
        part.x += n.x;
        part.y += n.y;
        part.xx += n.x * n.x;
        part.xy += n.x * n.y;
        part.yy += n.y * n.y;
        part.base += luminance(base_color_of(pixel));
    }
    partials[strip * parameters.size.x + x] = part;
}
