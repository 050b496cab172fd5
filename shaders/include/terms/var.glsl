// Reference: src/objective/terms/var.rs.
float term_var(Detail picture) {
    return 1.0 - min(sqrt(picture.variance * 12.0), 1.0);
}
