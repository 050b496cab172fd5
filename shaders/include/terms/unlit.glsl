// Reference: src/objective/terms/unlit.rs.
float term_unlit(Detail picture) {
    return min(picture.unlit / UNLIT_RANGE, 1.0);
}
