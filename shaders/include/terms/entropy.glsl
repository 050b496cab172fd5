// Reference: src/objective/terms/entropy.rs.
float term_entropy(Detail picture) {
    float flatness = 1.0 - min(picture.entropy / log(float(BINS)), 1.0);
    return view_statistics.normal_detail < GRAD_FLAT ? 0.0 : flatness;
}
