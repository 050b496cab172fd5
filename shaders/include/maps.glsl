// What the stages that run once for each view share; the Rust side is src/gpu/maps.rs.
// One entry a pixel, rows from the top.

#extension GL_EXT_samplerless_texture_functions : require

const uint BACKGROUND = 0u;
const uint SURFACE = 1u;
const uint EDGE = 2u;

// What is measured over the whole picture.
struct MapStatistics {
    uint depth;             // largest object depth, see ordered()
    uint surface;           // SURFACE pixels
    uint edge;              // EDGE pixels
    float normal_detail;    // G_n
};

layout(set = 0, binding = 0) uniform utexture2D code_map;
layout(set = 0, binding = 1) uniform texture2D position_depth_map;
layout(set = 0, binding = 2) uniform texture2D normal_roughness_map;
layout(set = 0, binding = 3) uniform texture2D base_metallic_map;
layout(set = 0, binding = 4) uniform texture2D emissive_map;
layout(set = 0, binding = 5, std430) buffer Statistics { MapStatistics statistics; };
layout(set = 0, binding = 6, std430) buffer Sobel { float sobel[]; };
layout(set = 0, binding = 7, std430) buffer Laplace { float laplace[]; };
layout(set = 0, binding = 8, std430) buffer Types { uint types[]; };
layout(set = 0, binding = 9, std430) buffer Visible { uint visible[]; };
layout(set = 0, binding = 10, std430) buffer Partials { float partials[]; };

layout(push_constant) uniform Settings {
    uvec2 size;
    float edge_sobel;
    float edge_laplace;
};

// Pixels that one invocation of a strip stage takes, one below the other.
const uint STRIP = 16u;

// Floats as integers of the same order, so that atomicMax finds the largest.
uint ordered(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float from_ordered(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0u ? key & 0x7fffffffu : ~key);
}

uint index_of(ivec2 pixel) {
    return uint(pixel.y) * size.x + uint(pixel.x);
}

bool inside(ivec2 pixel) {
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(size)));
}

bool is_object(ivec2 pixel) {
    return texelFetch(code_map, pixel, 0).r != 0u;
}
