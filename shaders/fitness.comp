#version 460
// Statistics and F of every individual, a work group each. Partial results are combined in a
// fixed order: first by invocation, then in a tree. References: Objective::terms, cpu::fitness.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 0) const uint GROUP = FITNESS_GROUP;
layout(constant_id = 1) const uint BINS = HISTOGRAM_BINS;
layout(constant_id = 2) const uint BITS = 8; // of a bin of a partial histogram, 8 or 16
const uint PACKED = 32 / BITS; // bins in a word
const uint WORDS = BINS / PACKED;
layout(constant_id = 3) const bool APPEARANCE = false; // whether there are such parts
layout(constant_id = 4) const bool CURVATURE = false; // whether there are histograms by curvature
const uint CURVED_WORDS = BINS / 2; // of such a histogram
const uint ENTRY = CURVATURE ? WORDS + CURVED_WORDS : WORDS;

#include "terms.glsl"

shared uint bins[GROUP * PACKED];
shared float disorder[GROUP]; // -p ln p
shared uint tally[BINS]; // pixels of each bin
shared float curved[CURVATURE ? GROUP * 2 : 1]; // what they count by curvature
shared vec2 curvature[CURVATURE ? GROUP : 1]; // c, c ln c
shared Moments moments[GROUP];
shared Gradient gradients[GROUP];
shared Appearance appearances[GROUP];

// Counts of the bins of a word of every so many entries.
void gather_histogram(uint individual, uint lane) {
    uint entries = chunk.histogram_entries;
    uint counts[PACKED];
    for (uint k = 0; k < PACKED; ++k) {
        counts[k] = 0;
    }
    for (uint e = lane / WORDS; e < entries; e += GROUP / WORDS) {
        uint word = histogram_parts[(individual * entries + e) * ENTRY + lane % WORDS];
        for (uint k = 0; k < PACKED; ++k) {
            counts[k] += bitfieldExtract(word, int(k * BITS), int(BITS));
        }
    }
    for (uint k = 0; k < PACKED; ++k) {
        bins[lane * PACKED + k] = counts[k];
    }
}

// The same of the histograms by curvature.
void gather_curved(uint individual, uint lane) {
    uint entries = chunk.histogram_entries;
    uvec2 counts = uvec2(0);
    for (uint e = lane / CURVED_WORDS; e < entries; e += GROUP / CURVED_WORDS) {
        uint word = histogram_parts[(individual * entries + e) * ENTRY + WORDS + lane % CURVED_WORDS];
        counts += uvec2(word & 0xffff, word >> 16);
    }
    curved[lane * 2] = float(counts.x);
    curved[lane * 2 + 1] = float(counts.y);
}

// Chan, Golub and LeVeque (1979): moments of two sets from those of each.
Moments combine(Moments a, Moments b) {
    uint count = a.count + b.count;
    float share = float(b.count) / float(max(count, 1));
    float distance = a.count == 0 ? 0.0 : b.mean - a.mean;
    float mean = a.count == 0 ? b.mean : a.mean + distance * share;
    float between = distance * distance * float(a.count) * share;
    return Moments(count, b.count == 0 ? a.mean : mean, a.deviation + b.deviation + between);
}

void gather_sums(uint individual, uint lane) {
    uint entries = chunk.entries;
    Moments moment = Moments(0, 0.0, 0.0);
    Gradient gradient = Gradient(0.0, 0.0);
    for (uint e = lane; e < entries; e += GROUP) {
        moment = combine(moment, moment_parts[individual * entries + e]);
        Gradient part = gradient_parts[individual * entries + e];
        gradient = Gradient(gradient.surface + part.surface, gradient.edge + part.edge);
    }
    moments[lane] = moment;
    gradients[lane] = gradient;
}

// Of two sets, as combine() of moments.
Appearance combine(Appearance a, Appearance b) {
    Moments e = combine(Moments(a.count, a.mean, a.deviation), Moments(b.count, b.mean, b.deviation));
    return Appearance(e.count, e.mean, e.deviation, a.covariance_x + b.covariance_x,
        a.covariance_y + b.covariance_y, a.burnt + b.burnt, a.unlit + b.unlit,
        a.residual + b.residual, a.detail + b.detail, a.outline_count + b.outline_count,
        a.outline + b.outline);
}

void gather_appearance(uint individual, uint lane) {
    Appearance sum = Appearance(0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, 0.0, 0, 0.0);
    for (uint e = lane; e < chunk.entries; e += GROUP) {
        sum = combine(sum, appearance_parts[individual * chunk.entries + e]);
    }
    appearances[lane] = sum;
}

// Mean distance of the percentiles from the example's, as a share of EXAMPLE_RANGE.
float example_brightness(uint objects) {
    uint below = 0;
    float apart = 0.0;
    // All pixels are below the end of the last bin in both.
    for (uint bin = 0; bin < BINS - 1; ++bin) {
        below += tally[bin];
        apart += abs(float(below) / float(max(objects, 1)) - example_entry(bin));
    }
    return min(apart / float(BINS) / EXAMPLE_RANGE, 1.0);
}

// Unit vector towards the individual's first key light; 0 without any.
vec3 key_direction(uint place) {
    for (uint i = 0; i < chunk.lights; ++i) {
        Light light = lights[place * chunk.lights + i];
        if (light.key > 0.0) {
            return normalize(light.position);
        }
    }
    return vec3(0.0);
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint individual = gl_WorkGroupID.x;
    uint place = chunk.first + individual;
    gather_histogram(individual, lane);
    gather_sums(individual, lane);
    if (APPEARANCE) {
        gather_appearance(individual, lane);
    }
    if (CURVATURE) {
        gather_curved(individual, lane);
    }
    barrier();
    uint objects = view_statistics.surface + view_statistics.edge;
    uint count = 0;
    if (lane < BINS) {
        for (uint l = 0; l < GROUP / WORDS; ++l) {
            count += bins[l * BINS + lane];
        }
        details[place].histogram[lane] = count;
        tally[lane] = count;
    }
    float p = float(count) / float(max(objects, 1));
    disorder[lane] = count > 0 ? -p * log(p) : 0.0;
    if (CURVATURE) {
        float sum = 0.0;
        for (uint l = 0; l < (lane < BINS ? GROUP / CURVED_WORDS : 0u); ++l) {
            sum += curved[l * BINS + lane];
        }
        curvature[lane] = vec2(sum, sum > 0.0 ? sum * log(sum) : 0.0);
    }
    barrier();
    for (uint half_size = GROUP / 2; half_size > 0; half_size /= 2) {
        if (lane < half_size) {
            uint other = lane + half_size;
            disorder[lane] += disorder[other];
            moments[lane] = combine(moments[lane], moments[other]);
            gradients[lane].surface += gradients[other].surface;
            gradients[lane].edge += gradients[other].edge;
            if (APPEARANCE) {
                appearances[lane] = combine(appearances[lane], appearances[other]);
            }
            if (CURVATURE) {
                curvature[lane] += curvature[other];
            }
        }
        barrier();
    }
    if (lane != 0) {
        return;
    }
    Detail picture;
    picture.edge_contrast = gradients[0].edge / float(max(view_statistics.edge, 1));
    picture.mean = moments[0].mean;
    picture.variance = moments[0].deviation / float(max(objects, 1));
    picture.gradient = gradients[0].surface / float(max(view_statistics.surface, 1));
    Appearance seen = Appearance(0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, 0.0, 0, 0.0);
    if (APPEARANCE) {
        seen = appearances[0];
    }
    float objects_or_one = float(max(objects, 1));
    picture.detail = seen.detail / max(view_statistics.detail_weight, 1e-30);
    picture.burnt = float(seen.burnt) / objects_or_one;
    picture.unlit = float(seen.unlit) / objects_or_one;
    picture.residual = seen.residual / float(max(view_statistics.target, 1));
    picture.outline = seen.outline / float(max(seen.outline_count, 1));
    picture.irradiance_mean = seen.mean;
    picture.irradiance_variance = seen.deviation / objects_or_one;
    picture.covariance_x = seen.covariance_x / objects_or_one;
    picture.covariance_y = seen.covariance_y / objects_or_one;
    vec3 key = key_direction(place);
    picture.key_x = key.x;
    picture.key_y = key.y;
    picture.key_z = key.z;
    picture.entropy = 0.0;
    if (CURVATURE && curvature[0].x > 0.0) {
        picture.entropy = max(log(curvature[0].x) - curvature[0].y / curvature[0].x, 0.0);
    }
    scores[place] = weighted_terms(picture, disorder[0], example_brightness(objects));
    details[place].edge_contrast = picture.edge_contrast;
    details[place].mean = picture.mean;
    details[place].variance = picture.variance;
    details[place].gradient = picture.gradient;
    details[place].detail = picture.detail;
    details[place].burnt = picture.burnt;
    details[place].unlit = picture.unlit;
    details[place].residual = picture.residual;
    details[place].outline = picture.outline;
    details[place].irradiance_mean = picture.irradiance_mean;
    details[place].irradiance_variance = picture.irradiance_variance;
    details[place].covariance_x = picture.covariance_x;
    details[place].covariance_y = picture.covariance_y;
    details[place].key_x = key.x;
    details[place].key_y = key.y;
    details[place].key_z = key.z;
    details[place].entropy = picture.entropy;
}
