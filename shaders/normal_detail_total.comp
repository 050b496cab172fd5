#version 460
// The shape that a view shows, second half: the strips' sums in a fixed order. One work group.
// References: src/cpu/normal_detail.rs, src/cpu/shape.rs.
#extension GL_GOOGLE_include_directive : require
#include "maps.glsl"

layout(local_size_x_id = 0) in;

shared ShapePart sums[gl_WorkGroupSize.x];

ShapePart add(ShapePart a, ShapePart b) {
    return ShapePart(a.gradient + b.gradient, a.weight + b.weight, a.x + b.x, a.y + b.y,
        a.xx + b.xx, a.xy + b.xy, a.yy + b.yy, a.base + b.base);
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint lanes = gl_WorkGroupSize.x; // a power of two
    uint strips = (parameters.size.y + STRIP - 1u) / STRIP * parameters.size.x;
    ShapePart sum = ShapePart(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (uint k = lane; k < strips; k += lanes) {
        sum = add(sum, partials[k]);
    }
    sums[lane] = sum;
    for (uint rest = lanes / 2u; rest > 0u; rest /= 2u) {
        barrier();
        if (lane < rest) {
            sums[lane] = add(sums[lane], sums[lane + rest]);
        }
    }
    if (lane != 0u) {
        return;
    }
    ShapePart all = sums[0];
    float count = float(max(view_statistics.surface + view_statistics.edge, 1u));
    vec2 mean = vec2(all.x, all.y) / count;
    view_statistics.normal_detail = all.gradient / float(max(view_statistics.surface, 1u));
    view_statistics.normal_mean = mean;
    view_statistics.normal_xx = all.xx / count - mean.x * mean.x;
    view_statistics.normal_xy = all.xy / count - mean.x * mean.y;
    view_statistics.normal_yy = all.yy / count - mean.y * mean.y;
    view_statistics.detail_weight = all.weight;
    view_statistics.base_luminance = all.base / count;
}
