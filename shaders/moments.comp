#version 460
// Mean and squared deviation of every picture over its object pixels. An invocation walks down one
// column of one strip; the first object pixel is the origin of its sums, so that an even picture
// deviates by exactly 0. Reference: cpu::moments.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint ROWS = SUM_ROWS; // of a strip

void main() {
    uint x = gl_GlobalInvocationID.x;
    if (x >= parameters.size.x) {
        return;
    }
    uint strip = gl_WorkGroupID.y;
    uint layer = gl_WorkGroupID.z;
    uint count = 0;
    float origin = 0.0;
    float sum = 0.0;
    float squares = 0.0;
    uint end = min((strip + 1) * ROWS, parameters.size.y);
    for (uint y = strip * ROWS; y < end; ++y) {
        float value = texelFetch(pictures, ivec3(x, y, layer), 0).x;
        bool object = value >= 0.0;
        origin = count == 0 ? value : origin;
        float distance = object ? value - origin : 0.0;
        count += object ? 1 : 0;
        sum += distance;
        squares += distance * distance;
    }
    float mean = count > 0 ? sum / float(count) : 0.0;
    uint entry = (layer * gl_NumWorkGroups.y + strip) * parameters.size.x + x;
    float deviation = max(squares - sum * mean, 0.0);
    moment_parts[entry] = Moments(count, count > 0 ? origin + mean : 0.0, deviation);
}
