// Reference: src/objective/terms/target.rs.
float term_target(Detail picture) {
    return min(sqrt(picture.residual) / TARGET_RANGE, 1.0);
}
