// Reference: src/objective/terms/hist.rs. The entropy of the histogram is `disorder`, nats.
float term_hist(float disorder) {
    return 1.0 - disorder / log(float(BINS));
}
