// Reference: src/objective/terms/spread.rs.
float term_spread(Detail picture) {
    float target = parameters.spread_target;
    return abs(sqrt(picture.variance) - target) / max(target, SPREAD_MOST - target);
}
