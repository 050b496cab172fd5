// Reference: src/objective/terms/burnt.rs.
float term_burnt(Detail picture) {
    const float TOLERATED = 0.005;
    const float RANGE = 0.05;
    return min(max(picture.burnt - TOLERATED, 0.0) / RANGE, 1.0);
}
