// Reference: src/objective/terms/target.rs.
float term_target(Detail picture) {
    const float RANGE = 0.25;
    return min(sqrt(picture.residual) / RANGE, 1.0);
}
