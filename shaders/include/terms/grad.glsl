// Reference: src/objective/terms/grad.rs.
float term_grad(Detail picture) {
    float detail = view_statistics.normal_detail;
    return detail < GRAD_FLAT ? 0.0 : 1.0 - min(picture.gradient / detail, 1.0);
}
