// Reference: src/objective/terms/range.rs.
float term_range(Detail picture) {
    const float ENOUGH = 0.2;
    return 1.0 - min(sqrt(picture.variance) / ENOUGH, 1.0);
}
