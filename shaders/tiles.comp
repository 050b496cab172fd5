#version 460
// Statistics of a block of individuals over one tile of the picture: the surface is read once, the
// brightnesses of tile and border stand in shared memory, and subgroups add up. Nothing of the
// pictures is kept, save the first. One pixel at a time is in registers: the fewer there are, the more
// invocations hide each other's waiting. References: cpu::population, cpu::histogram, cpu::moments,
// cpu::gradient.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "layout.glsl"
#include "appearance.glsl"
#include "tile.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 0) const uint GROUP = TILES_GROUP;
layout(constant_id = 1) const uint LIGHTS = 1;
layout(constant_id = 2) const uint SUBGROUP = 32; // invocations
layout(constant_id = 3) const uint SIDE = TILE_SIDE; // of a tile, pixels
layout(constant_id = 4) const uint BLOCK = TILES_BLOCK; // individuals
layout(constant_id = 5) const bool COLOR = false; // whether to shade in colour
layout(constant_id = 6) const bool GLTF = false;
layout(constant_id = 7) const bool MEASURE_LIGHTS = false; // what is measured besides
layout(constant_id = 8) const bool DETAIL = false;
layout(constant_id = 9) const bool TARGET = false;
layout(constant_id = 10) const bool OUTLINE = false;
layout(constant_id = 11) const bool CURVATURE = false;
layout(constant_id = 12) const uint SHADOW_SIDE = 0;
layout(constant_id = 13) const bool NEAR_LIGHTS = false;

#include "color.glsl"

const uint FRAME = SIDE + 2; // the same with its border
const uint AREA = FRAME * FRAME;
const uint PIXELS = SIDE * SIDE / GROUP; // of an invocation
const uint SUBGROUPS = GROUP / SUBGROUP;
const uint BIN_BITS = HISTOGRAM_BIN_BITS;
const uint BINS = HISTOGRAM_BINS;
const uint WORDS = BINS / 2; // of the histogram, and of the one by curvature
const uint ENTRY = CURVATURE ? 2 * WORDS : WORDS;
const bool APPEARANCE = MEASURE_LIGHTS || DETAIL || TARGET || OUTLINE;
const uint OWN = SUBGROUP < BINS ? BINS / SUBGROUP : 1; // bins that an invocation counts

layout(set = 1, binding = 0, std430) readonly buffer Tiles { Tile tiles[]; };
layout(set = 1, binding = 1, std430) writeonly buffer Picture { float picture[]; };

shared vec4 light_places[COLOR ? 1 : BLOCK * LIGHTS];
shared vec2 light_strengths[COLOR ? 1 : BLOCK * LIGHTS];
shared float frames[BLOCK * AREA]; // of each individual the tile with its border
shared uint bins[BLOCK * BINS];
shared vec4 sums[BLOCK * SUBGROUPS]; // distances from the origin, their squares, SURFACE, EDGE
shared float origins[BLOCK];
// In colour the irradiances beside the brightnesses; see encoded().
shared float irradiances[COLOR ? BLOCK * AREA : 1];
shared float irradiance_origins[BLOCK];
// Of the irradiance: distances from the origin, their squares, and the covariances.
shared vec4 light_sums[APPEARANCE ? BLOCK * SUBGROUPS : 1];
// Residual, detail, and the numbers of burnt-out and unlit pixels.
shared vec4 other_sums[APPEARANCE ? BLOCK * SUBGROUPS : 1];
// The number of pixels of the outline, and their sum.
shared vec2 outline_sums[OUTLINE ? BLOCK * SUBGROUPS : 1];
shared uint counts[SUBGROUPS];
shared uint curved[CURVATURE ? BLOCK * BINS : 1];

void load_lights(uint first) {
    for (uint i = gl_LocalInvocationIndex; i < (COLOR ? 0 : BLOCK * LIGHTS); i += GROUP) {
        Light light = lights[first + i];
        light_places[i] = vec4(light.position, light.radius2);
        light_strengths[i] = vec2(light.diffuse, light.specular);
    }
}

// How the surface of a pixel reflects.
ColorReflectance color_looks(ivec2 pixel) {
    vec4 diffuse = texelFetch(color_surface, ivec3(pixel, 0), 0);
    vec3 specular = texelFetch(color_surface, ivec3(pixel, 1), 0).rgb;
    return ColorReflectance(
        diffuse.rgb, specular, diffuse.w, texelFetch(color_surface, ivec3(pixel, 2), 0).rgb);
}

// Shades a pixel under the lights of each individual.
void shade(uint at, uint first_light, ivec2 pixel) {
    vec4 place = texelFetch(surface_0, pixel, 0);
    vec4 facing = texelFetch(surface_1, pixel, 0);
    vec3 p = place.xyz;
    vec3 n = facing.xyz;
    vec3 v = to_viewer(p);
    if (COLOR) {
        ColorReflectance looks = color_looks(pixel);
        for (uint i = 0; i < BLOCK; ++i) {
            Lit lit = Lit(looks.unlit, 0.0);
            for (uint l = 0; l < LIGHTS; ++l) {
                add_light(lights[first_light + i * LIGHTS + l], pixel, p, n, v, looks, lit);
            }
            vec2 color = encoded(lit);
            frames[i * AREA + at] = color.x;
            irradiances[i * AREA + at] = color.y;
        }
        return;
    }
    vec2 look = texelFetch(surface_2, pixel, 0).xy; // specular, unlit
    for (uint i = 0; i < BLOCK; ++i) {
        vec2 response = vec2(0.0);
        for (uint l = 0; l < LIGHTS; ++l) {
            uint light = i * LIGHTS + l;
            response += light_response(
                light_places[light], light_strengths[light], p, n, v, place.w);
        }
        frames[i * AREA + at] = srgb_encode(look.y + response.x * facing.w + response.y * look.x);
    }
}

// Adds a bin of each invocation to the counts of each bin. A bin's owner learns by ballots, one for each
// bit of the bin's number, how many of the subgroup fell into it: no atomics, and equally fast for every
// picture.
void count_bins(bool object, uint bin, inout uint counted[OWN]) {
    uvec4 present = subgroupBallot(object);
    uvec4 ballots[BIN_BITS];
    [[unroll]] for (uint k = 0; k < BIN_BITS; ++k) {
        ballots[k] = subgroupBallot((bin >> k & 1) != 0);
    }
    [[unroll]] for (uint o = 0; o < OWN; ++o) {
        uint own = gl_SubgroupInvocationID + o * SUBGROUP;
        uvec4 same = present;
        [[unroll]] for (uint k = 0; k < BIN_BITS; ++k) {
            same &= (own >> k & 1) != 0 ? ballots[k] : ~ballots[k];
        }
        counted[o] += subgroupBallotBitCount(same);
    }
}

float tap(uint at, float center) {
    float value = frames[at];
    return value < 0.0 ? center : value;
}

// Length of the gradient around a place of the frames.
float slope(uint at, float center) {
    float a = tap(at - FRAME - 1, center);
    float b = tap(at - FRAME, center);
    float c = tap(at - FRAME + 1, center);
    float d = tap(at - 1, center);
    float f = tap(at + 1, center);
    float g = tap(at + FRAME - 1, center);
    float h = tap(at + FRAME, center);
    float i = tap(at + FRAME + 1, center);
    return length(vec2((c + 2.0 * f + i) - (a + 2.0 * d + g),
        (g + 2.0 * h + i) - (a + 2.0 * b + c))) / 8.0;
}

// Where the block's partial results of the tile go.
uint first_part() {
    return gl_WorkGroupID.y * BLOCK * chunk.entries + gl_WorkGroupID.x;
}

// Of a tile without object pixels.
void write_nothing() {
    uint first = first_part();
    for (uint k = gl_LocalInvocationIndex; k < BLOCK * ENTRY; k += GROUP) {
        histogram_parts[(first + k / ENTRY * chunk.entries) * ENTRY + k % ENTRY] = 0;
    }
    uint i = gl_LocalInvocationIndex;
    if (i < BLOCK) {
        moment_parts[first + i * chunk.entries] = Moments(0, 0.0, 0.0);
        gradient_parts[first + i * chunk.entries] = Gradient(0.0, 0.0);
        if (APPEARANCE) {
            appearance_parts[first + i * chunk.entries] = part_of(no_sums());
        }
    }
}

// Adds up the subgroups and writes the block's partial results of the tile.
void write_parts() {
    uint first = first_part();
    for (uint k = gl_LocalInvocationIndex; k < BLOCK * WORDS; k += GROUP) {
        uint i = k / WORDS;
        uint word = k % WORDS;
        uint at = i * BINS + 2 * word;
        uint entry = (first + i * chunk.entries) * ENTRY + word;
        histogram_parts[entry] = bins[at] | bins[at + 1] << 16;
        if (CURVATURE) {
            histogram_parts[entry + WORDS] = curved[at] | curved[at + 1] << 16;
        }
    }
    uint i = gl_LocalInvocationIndex;
    if (i < BLOCK) {
        vec4 total = vec4(0.0);
        uint count = 0;
        for (uint s = 0; s < SUBGROUPS; ++s) {
            total += sums[i * SUBGROUPS + s];
            count += counts[s];
        }
        float mean = total.x / float(count); // the tile has an object pixel
        float deviation = max(total.y - total.x * mean, 0.0);
        moment_parts[first + i * chunk.entries] = Moments(count, origins[i] + mean, deviation);
        gradient_parts[first + i * chunk.entries] = Gradient(total.z, total.w);
        if (APPEARANCE) {
            vec4 light = vec4(0.0);
            vec4 other = vec4(0.0);
            vec2 outline = vec2(0.0);
            for (uint s = 0; s < SUBGROUPS; ++s) {
                light += light_sums[i * SUBGROUPS + s];
                other += other_sums[i * SUBGROUPS + s];
                outline += OUTLINE ? outline_sums[i * SUBGROUPS + s] : vec2(0.0);
            }
            appearance_parts[first + i * chunk.entries] = part_of(Sums(MEASURE_LIGHTS ? count : 0,
                irradiance_origins[i], light.x, light.y, light.zw, uint(other.z), uint(other.w),
                other.x, other.y, uint(outline.x), outline.y));
        }
    }
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    Tile tile = tiles[gl_WorkGroupID.x];
    if (tile.origin == EMPTY_TILE) {
        write_nothing();
        return;
    }
    ivec2 corner = ivec2(tile.column, tile.row) * int(SIDE);
    uint first = chunk.first + gl_WorkGroupID.y * BLOCK;
    load_lights(first * LIGHTS);
    for (uint b = lane; b < BLOCK * BINS; b += GROUP) {
        bins[b] = 0;
        if (CURVATURE) {
            curved[b] = 0;
        }
    }
    barrier();
    for (uint at = lane; at < AREA; at += GROUP) {
        ivec2 pixel = corner - 1 + ivec2(at % FRAME, at / FRAME);
        bool object = all(greaterThanEqual(pixel, ivec2(0)))
            && all(lessThan(pixel, ivec2(parameters.size)))
            && type_at(pixel) != BACKGROUND;
        if (object) {
            shade(at, first * LIGHTS, pixel);
        } else {
            [[unroll]] for (uint i = 0; i < BLOCK; ++i) {
                frames[i * AREA + at] = NO_OBJECT;
            }
        }
    }
    barrier();
    uint kinds[PIXELS];
    bool outlines[PIXELS];
    uint pixel_count = 0;
    [[unroll]] for (uint k = 0; k < PIXELS; ++k) {
        uint at = lane + k * GROUP;
        ivec2 place = corner + ivec2(at % SIDE, at / SIDE);
        bool inside = all(lessThan(place, ivec2(parameters.size)));
        kinds[k] = inside ? type_at(place) : BACKGROUND;
        outlines[k] = OUTLINE && kinds[k] != BACKGROUND && is_outline(place);
        pixel_count += kinds[k] != BACKGROUND ? 1 : 0;
    }
    uint count = subgroupAdd(pixel_count);
    for (uint i = 0; i < BLOCK; ++i) {
        uint frame = i * AREA;
        float origin = frames[frame + tile.origin];
        vec4 sum = vec4(0.0);
        Sums more = no_sums();
        if (MEASURE_LIGHTS) {
            // All distances are from one origin, as those of the brightness.
            float value = irradiances[frame + tile.origin];
            more.origin = value < 0.0 ? -1.0 - value : value;
            more.count = 1;
        }
        float irradiance_origin = more.origin;
        uint counted[OWN];
        [[unroll]] for (uint o = 0; o < OWN; ++o) {
            counted[o] = 0;
        }
        [[unroll]] for (uint k = 0; k < PIXELS; ++k) {
            uint pixel = lane + k * GROUP;
            uint x = pixel % SIDE;
            uint y = pixel / SIDE;
            uint at = frame + (y + 1) * FRAME + x + 1;
            bool object = kinds[k] != BACKGROUND;
            float center = frames[at];
            float distance = object ? center - origin : 0.0;
            float steep = slope(at, center);
            sum += vec4(distance, distance * distance, kinds[k] == SURFACE ? steep : 0.0,
                kinds[k] == EDGE ? min(steep / parameters.edge_contrast, 1.0) : 0.0);
            if (APPEARANCE && object) {
                ivec2 place = corner + ivec2(x, y);
                if (MEASURE_LIGHTS) {
                    add_lights(irradiances[at], texelFetch(surface_1, place, 0).xy, more);
                }
                if (DETAIL && kinds[k] == SURFACE) {
                    add_detail(steep, texelFetch(color_surface, ivec3(place, 1), 0).w, more);
                }
                if (TARGET) {
                    add_target(center, texelFetch(color_surface, ivec3(place, 2), 0).w, more);
                }
                if (outlines[k]) {
                    add_outline(center, more);
                }
            }
            uint bin = min(uint(max(center, 0.0) * float(BINS)), BINS - 1);
            count_bins(object, bin, counted);
            if (CURVATURE && object) {
                ivec2 place = corner + ivec2(x, y);
                atomicAdd(curved[i * BINS + bin], curvature_level(texelFetch(color_surface, ivec3(place, 1), 0).w));
            }
            if (object && gl_WorkGroupID.y == 0 && i == 0) {
                picture[(uint(corner.y) + y) * parameters.size.x + uint(corner.x) + x] = center;
            }
        }
        sum = subgroupAdd(sum);
        uint at = i * SUBGROUPS + gl_SubgroupID;
        vec4 light_sum = vec4(0.0);
        vec4 other_sum = vec4(0.0);
        vec2 outline_sum = vec2(0.0);
        if (APPEARANCE) {
            light_sum = subgroupAdd(vec4(more.sum, more.squares, more.covariance));
            other_sum = subgroupAdd(
                vec4(more.residual, more.detail, float(more.burnt), float(more.unlit)));
        }
        if (OUTLINE) {
            outline_sum = subgroupAdd(vec2(float(more.outline_count), more.outline));
        }
        if (subgroupElect()) {
            sums[at] = sum;
            counts[gl_SubgroupID] = count;
            if (APPEARANCE) {
                light_sums[at] = light_sum;
                other_sums[at] = other_sum;
            }
            if (OUTLINE) {
                outline_sums[at] = outline_sum;
            }
        }
        [[unroll]] for (uint o = 0; o < OWN; ++o) {
            uint own = gl_SubgroupInvocationID + o * SUBGROUP;
            if (own < BINS) {
                atomicAdd(bins[i * BINS + own], counted[o]);
            }
        }
        if (lane == 0) {
            origins[i] = origin;
            irradiance_origins[i] = irradiance_origin;
        }
    }
    barrier();
    write_parts();
}
