// What host and shaders share: set 0, which every stage of a view binds. The other side is
// src/gpu/layout.rs.
#ifndef KLIEG_LAYOUT
#define KLIEG_LAYOUT

#extension GL_EXT_samplerless_texture_functions : require

#include "constants.glsl"
#include "light.glsl"

layout(set = 0, binding = 0, std140) uniform Parameters {
    uvec2 size; // width and height, pixels
    uint orthographic; // whether all view rays are parallel
    uint padding;
    vec3 eye; // the viewer in the light frame, scene radii
    float ambient;
    float dielectric;
    float max_shininess;
    float edge_sobel;
    float edge_laplace;
    float edge_contrast;
    float mean_target;
    float weight_edge;
    float weight_mean;
    float weight_grad;
    float weight_var;
    float weight_hist;
    float padding_end;
} parameters;

// Unit vector to the viewer.
vec3 to_viewer(vec3 p) {
    return parameters.orthographic != 0 ? vec3(0.0, 0.0, 1.0) : normalize(parameters.eye - p);
}

// Of the shading model: ambient, dielectric, max_shininess.
vec3 shading_constants() {
    return vec3(parameters.ambient, parameters.dielectric, parameters.max_shininess);
}

// The visible surface, as the visibility draw wrote it.
layout(set = 0, binding = 1) uniform utexture2D code_map;
layout(set = 0, binding = 2) uniform texture2D position_roughness_map;
layout(set = 0, binding = 3) uniform texture2D normal_metallic_map;
layout(set = 0, binding = 4) uniform texture2D base_color_map;
layout(set = 0, binding = 5) uniform texture2D emissive_map;

// Maps made from it.
layout(set = 0, binding = 6, r32f) uniform image2D depth_map;
layout(set = 0, binding = 7, r32f) uniform image2D sobel_map;
layout(set = 0, binding = 8, r32f) uniform image2D laplace_map;
layout(set = 0, binding = 9, r32ui) uniform uimage2D type_map;

// The surface as the population reads it: position and shininess; normal and diffuse reflectance;
// specular reflectance, unlit luminance and pixel type. Reflectances are luminances.
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D record_0;
layout(set = 0, binding = 11, rgba32f) uniform writeonly image2D record_1;
layout(set = 0, binding = 12, rgba32f) uniform writeonly image2D record_2;
layout(set = 0, binding = 13) uniform texture2D surface_0;
layout(set = 0, binding = 14) uniform texture2D surface_1;
layout(set = 0, binding = 15) uniform texture2D surface_2;

layout(set = 0, binding = 16, std430) buffer ViewStatistics {
    uint surface; // SURFACE pixels
    uint edge; // EDGE pixels
    float normal_detail; // G_n
    float background_depth; // the largest object depth + 1
} view_statistics;

// The population's pictures: sRGB-encoded luminance 0..1, NO_OBJECT in the background.
layout(set = 0, binding = 17) uniform texture2DArray pictures;

layout(set = 0, binding = 18, std430) readonly buffer Lights {
    Light lights[];
};

// Partial results, so many of each picture as the chunk says.
struct Moments {
    uint count; // object pixels
    float mean;
    float deviation; // sum of the squared distances from the mean
};
struct Gradient {
    float surface; // sum over SURFACE of |grad I|
    float edge; // sum over EDGE of min(1, |grad I| / edge_contrast)
};
layout(set = 0, binding = 19, std430) buffer HistogramParts {
    uint histogram_parts[]; // a byte, or in tiles 16 bits, for each bin
};
layout(set = 0, binding = 20, std430) buffer MomentParts {
    Moments moment_parts[];
};
layout(set = 0, binding = 21, std430) buffer GradientParts {
    Gradient gradient_parts[];
};

layout(set = 0, binding = 22, std430) writeonly buffer Scores {
    float scores[];
};
struct Detail {
    float edge; // the five terms
    float mean;
    float grad;
    float var;
    float hist;
    float picture_edge_contrast; // and what they were made from
    float picture_mean;
    float picture_variance;
    float picture_gradient;
    uint histogram[HISTOGRAM_BINS];
};
layout(set = 0, binding = 23, std430) writeonly buffer Details {
    Detail details[];
};

// The part of a population that is measured at once.
layout(push_constant) uniform Chunk {
    uint first; // its first individual
    uint histogram_entries; // partial histograms of each picture
    uint entries; // partial moments and gradients of each picture
    uint block; // of individuals, within the chunk
    uint light; // the block's first light, within the window of lights
} chunk;

#endif
