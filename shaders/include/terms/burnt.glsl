// Reference: src/objective/terms/burnt.rs.
float term_burnt(Detail picture) {
    return min(max(picture.burnt - BURNT_TOLERATED, 0.0) / BURNT_RANGE, 1.0);
}
