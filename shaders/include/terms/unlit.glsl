// Reference: src/objective/terms/unlit.rs.
float term_unlit(Detail picture) {
    const float RANGE = 0.15;
    return min(picture.unlit / RANGE, 1.0);
}
