// The terms, in the order of TERMS in src/objective/terms/mod.rs. The including shader defines BINS.
#ifndef KLIEG_TERMS
#define KLIEG_TERMS

#include "terms/edge.glsl"
#include "terms/mean.glsl"
#include "terms/grad.glsl"
#include "terms/var.glsl"
#include "terms/hist.glsl"
#include "terms/detail.glsl"
#include "terms/range.glsl"
#include "terms/burnt.glsl"
#include "terms/unlit.glsl"
#include "terms/relief.glsl"
#include "terms/direction.glsl"
#include "terms/target.glsl"
#include "terms/outline.glsl"
#include "terms/spread.glsl"
#include "terms/example.glsl"
#include "terms/entropy.glsl"

// F: the weighted sum of the terms. A term of weight 0 is not computed.
float weighted_terms(Detail picture, float disorder, float brightness) {
    float sum = 0.0;
#define TERM(index, value) \
    if (parameters.weights[index / 4][index % 4] > 0.0) { \
        sum += parameters.weights[index / 4][index % 4] * (value); \
    }
    TERM(0, term_edge(picture))
    TERM(1, term_mean(picture))
    TERM(2, term_grad(picture))
    TERM(3, term_var(picture))
    TERM(4, term_hist(disorder))
    TERM(5, term_detail(picture))
    TERM(6, term_range(picture))
    TERM(7, term_burnt(picture))
    TERM(8, term_unlit(picture))
    TERM(9, term_relief(picture))
    TERM(10, term_direction(picture))
    TERM(11, term_target(picture))
    TERM(12, term_outline(picture))
    TERM(13, term_spread(picture))
    TERM(14, term_example(picture, brightness))
    TERM(15, term_entropy(picture))
#undef TERM
    return sum;
}

#endif
