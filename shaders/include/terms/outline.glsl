// Reference: src/objective/terms/outline.rs.
float term_outline(Detail picture) {
    return min(picture.outline, 1.0);
}
