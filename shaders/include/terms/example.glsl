// Reference: src/objective/terms/example.rs. `brightness` is the distance of the histograms, see example_brightness().
float term_example(Detail picture, float brightness) {
    float wanted = example_entry(BINS - 1);
    float most = max(max(picture.gradient, wanted), GRAD_FLAT);
    return mix(brightness, abs(picture.gradient - wanted) / most, EXAMPLE_GRADIENT);
}
