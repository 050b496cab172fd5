// Reference: src/objective/terms/mean.rs.
float term_mean(Detail picture) {
    float target = parameters.mean_target;
    return abs(picture.mean - target) / max(target, 1.0 - target);
}
