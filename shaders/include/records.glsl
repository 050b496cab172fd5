// The surface as the population reads it, written; layout.glsl says what stands where. The other side is
// src/gpu/view/records.rs.
#ifndef KLIEG_RECORDS
#define KLIEG_RECORDS

#include "layout.glsl"

layout(set = 1, binding = 0, rgba32f) uniform writeonly image2D record_0;
layout(set = 1, binding = 1, rgba32f) uniform writeonly image2D record_1;
layout(set = 1, binding = 2, rgba32f) uniform writeonly image2D record_2;
layout(set = 1, binding = 3, rgba32f) uniform writeonly image2DArray color_records;

#endif
