#version 460
// The five terms and F of every individual, a work group each. Partial results are combined in a
// fixed order: first by invocation, then in a tree. References: Objective::terms, cpu::fitness.
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 0) const uint GROUP = FITNESS_GROUP;
layout(constant_id = 1) const uint BINS = HISTOGRAM_BINS;
layout(constant_id = 2) const uint BITS = 8; // of a bin of a partial histogram, 8 or 16
const uint PACKED = 32 / BITS; // bins in a word
const uint WORDS = BINS / PACKED;

shared uint bins[GROUP * PACKED];
shared float disorder[GROUP]; // -p ln p
shared Moments moments[GROUP];
shared Gradient gradients[GROUP];

// Counts of the bins of a word of every so many entries.
void gather_histogram(uint individual, uint lane) {
    uint entries = chunk.histogram_entries;
    uint counts[PACKED];
    for (uint k = 0; k < PACKED; ++k) {
        counts[k] = 0;
    }
    for (uint e = lane / WORDS; e < entries; e += GROUP / WORDS) {
        uint word = histogram_parts[(individual * entries + e) * WORDS + lane % WORDS];
        for (uint k = 0; k < PACKED; ++k) {
            counts[k] += bitfieldExtract(word, int(k * BITS), int(BITS));
        }
    }
    for (uint k = 0; k < PACKED; ++k) {
        bins[lane * PACKED + k] = counts[k];
    }
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

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint individual = gl_WorkGroupID.x;
    uint place = chunk.first + individual;
    gather_histogram(individual, lane);
    gather_sums(individual, lane);
    barrier();
    uint objects = view_statistics.surface + view_statistics.edge;
    uint count = 0;
    if (lane < BINS) {
        for (uint l = 0; l < GROUP / WORDS; ++l) {
            count += bins[l * BINS + lane];
        }
        details[place].histogram[lane] = count;
    }
    float p = float(count) / float(max(objects, 1));
    disorder[lane] = count > 0 ? -p * log(p) : 0.0;
    barrier();
    for (uint half_size = GROUP / 2; half_size > 0; half_size /= 2) {
        if (lane < half_size) {
            uint other = lane + half_size;
            disorder[lane] += disorder[other];
            moments[lane] = combine(moments[lane], moments[other]);
            gradients[lane].surface += gradients[other].surface;
            gradients[lane].edge += gradients[other].edge;
        }
        barrier();
    }
    if (lane != 0) {
        return;
    }
    float contrast = gradients[0].edge / float(max(view_statistics.edge, 1));
    float slope = gradients[0].surface / float(max(view_statistics.surface, 1));
    float mean = moments[0].mean;
    float variance = moments[0].deviation / float(max(objects, 1));
    float target = parameters.mean_target;
    float detail = view_statistics.normal_detail;
    float f_edge = view_statistics.edge == 0 ? 0.0 : 1.0 - contrast;
    float f_mean = abs(mean - target) / max(target, 1.0 - target);
    float f_grad = detail < FLAT_NORMALS ? 0.0 : 1.0 - min(slope / detail, 1.0);
    float f_var = 1.0 - min(sqrt(variance * 12.0), 1.0);
    float f_hist = 1.0 - disorder[0] / log(float(BINS));
    scores[place] = parameters.weight_edge * f_edge + parameters.weight_mean * f_mean
        + parameters.weight_grad * f_grad + parameters.weight_var * f_var
        + parameters.weight_hist * f_hist;
    details[place].edge = f_edge;
    details[place].mean = f_mean;
    details[place].grad = f_grad;
    details[place].var = f_var;
    details[place].hist = f_hist;
    details[place].picture_edge_contrast = contrast;
    details[place].picture_mean = mean;
    details[place].picture_variance = variance;
    details[place].picture_gradient = slope;
}
