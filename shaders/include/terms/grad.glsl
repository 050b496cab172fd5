// Reference: src/objective/terms/grad.rs.
float term_grad(Detail picture) {
    const float FLAT_NORMALS = 1e-6;
    float detail = view_statistics.normal_detail;
    return detail < FLAT_NORMALS ? 0.0 : 1.0 - min(picture.gradient / detail, 1.0);
}
