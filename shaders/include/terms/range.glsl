// Reference: src/objective/terms/range.rs.
float term_range(Detail picture) {
    return 1.0 - min(sqrt(picture.variance) / RANGE_ENOUGH, 1.0);
}
