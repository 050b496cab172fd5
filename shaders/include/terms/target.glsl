// Reference: src/objective/terms/target.rs.
float term_target(Detail picture) {
    float distance = sqrt(picture.residual);
    return (1.0 + TARGET_RANGE) * distance / (distance + TARGET_RANGE);
}
