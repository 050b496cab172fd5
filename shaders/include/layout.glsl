// What host and shaders share: set 0, which every stage of a view binds. The other side is
// src/gpu/layout/.
#ifndef KLIEG_LAYOUT
#define KLIEG_LAYOUT

#extension GL_EXT_samplerless_texture_functions : require

#include "constants.glsl"
#include "light.glsl"
#include "octahedral.glsl"

layout(set = 0, binding = 0, std140) uniform Parameters {
    uvec2 size; // width and height, pixels
    uint orthographic; // whether all view rays are parallel
    float mean_stops; // of mean_target, 0 for none
    vec3 eye; // the viewer in the light frame, scene radii
    float ambient;
    float dielectric;
    float max_shininess;
    float edge_sobel;
    float edge_laplace;
    float edge_contrast;
    float mean_target;
    float background; // luminance behind the objects, sRGB-encoded
    float spread_target;
    vec4 weights[4]; // of the terms, in the order of term() in terms.glsl
    vec4 example[8]; // share of the pixels up to each bin but the last, in whose place is the gradient
} parameters;

// An entry of the example.
float example_entry(uint at) {
    return parameters.example[at / 4][at % 4];
}

// Unit vector to the viewer. There is no branch: Mesa 22.3 makes software devices compile a shader in which
// one depends on uniforms alone again for each dispatch.
vec3 to_viewer(vec3 p) {
    return mix(normalize(parameters.eye - p), vec3(0.0, 0.0, 1.0), bvec3(parameters.orthographic != 0));
}

// Of the shading model: ambient, dielectric, max_shininess.
vec3 shading_constants() {
    return vec3(parameters.ambient, parameters.dielectric, parameters.max_shininess);
}

// The visible surface, as the visibility draw wrote it.
layout(set = 0, binding = 1) uniform utexture2D code_map;
layout(set = 0, binding = 2) uniform texture2D position_roughness_map;
layout(set = 0, binding = 3) uniform texture2D normal_metallic_map;
// Layer 0: base colour, and x of the polygon's normal; layer 1: emitted radiance, and y.
layout(set = 0, binding = 4) uniform texture2DArray material_map;

vec3 base_color_of(ivec2 pixel) {
    return texelFetch(material_map, ivec3(pixel, 0), 0).rgb;
}

vec3 emissive_of(ivec2 pixel) {
    return texelFetch(material_map, ivec3(pixel, 1), 0).rgb;
}

// The polygon's unit normal, turned to the viewer.
vec3 face_of(ivec2 pixel) {
    return octahedral_decode(vec2(
        texelFetch(material_map, ivec3(pixel, 0), 0).w,
        texelFetch(material_map, ivec3(pixel, 1), 0).w));
}

// BACKGROUND, SURFACE or EDGE, made from it; maps.glsl has the maps between.
layout(set = 0, binding = 5) uniform utexture2D type_map;

uint type_at(ivec2 pixel) {
    return texelFetch(type_map, pixel, 0).r;
}

// The surface as the population reads it, which records.glsl writes: position and shininess; normal and
// diffuse reflectance; specular reflectance, unlit luminance and pixel type. Reflectances are luminances.
layout(set = 0, binding = 6) uniform texture2D surface_0;
layout(set = 0, binding = 7) uniform texture2D surface_1;
layout(set = 0, binding = 8) uniform texture2D surface_2;

// The same for shading in colour, in layers: diffuse reflectance and lobe; specular reflectance and
// |grad n| on SURFACE; unlit radiance and target picture; with shadows the polygon's normal and the ambient
// occlusion. See color.glsl. A single pixel where nothing is in colour.
layout(set = 0, binding = 9) uniform texture2DArray color_surface;

// Bindings 10 to 14, the shadow table and the occluders, are in shadow.glsl.

layout(set = 0, binding = 15, std430) buffer ViewStatistics {
    uint surface; // SURFACE pixels
    uint edge; // EDGE pixels
    float normal_detail; // G_n
    float background_depth; // the largest object depth + 1
    vec2 normal_mean; // means of the normals' x and y over the object
    float normal_xx; // their covariance matrix
    float normal_xy;
    float normal_yy;
    float detail_weight; // sum over SURFACE of min(|grad n|, 0.5)
    float base_luminance; // mean over the object
    uint target; // pixels that the target picture tells
} view_statistics;

// The population's pictures: sRGB-encoded luminance 0..1, NO_OBJECT in the background; in colour the
// irradiance beside it, see encoded() in color.glsl.
layout(set = 0, binding = 16) uniform texture2DArray pictures;

layout(set = 0, binding = 17, std430) readonly buffer Lights {
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
layout(set = 0, binding = 18, std430) buffer HistogramParts {
    // A byte, or in tiles 16 bits, for each bin; behind them, where it is measured, 16 bits for what each bin's
    // pixels count by curvature.
    uint histogram_parts[];
};
layout(set = 0, binding = 19, std430) buffer MomentParts {
    Moments moment_parts[];
};
layout(set = 0, binding = 20, std430) buffer GradientParts {
    Gradient gradient_parts[];
};

// What the lights do, of the encoded irradiance e = sRGB(min(1, E)) and the normals.
struct Appearance {
    uint count; // object pixels
    float mean; // of e
    float deviation; // sum of its squared distances from the mean
    float covariance_x; // sum of e times the normals' distance from their mean
    float covariance_y;
    uint burnt; // pixels with a channel that is burnt out
    uint unlit; // pixels of too little irradiance
    float residual; // sum of squared distances from the target picture
    float detail; // sum over SURFACE of the weight of the detail that is seen
    uint outline_count; // pixels beside the background
    float outline; // sum over them of what merges with it
};
layout(set = 0, binding = 21, std430) buffer AppearanceParts {
    Appearance appearance_parts[];
};

layout(set = 0, binding = 22, std430) writeonly buffer Scores {
    float scores[];
};
// Statistics of an individual, as Statistics of the reference.
struct Detail {
    float edge_contrast;
    float mean;
    float variance;
    float gradient;
    float detail;
    float burnt;
    float unlit;
    float residual;
    float outline;
    float irradiance_mean;
    float irradiance_variance;
    float covariance_x; // of the irradiance with the normals' x and y
    float covariance_y;
    float key_x; // unit vector towards the first key light; 0 without any
    float key_y;
    float key_z;
    float entropy; // of the histogram by curvature, nats
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
    uint lights; // lights of an individual
} chunk;

#endif
