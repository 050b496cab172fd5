// Reference: src/objective/terms/relief.rs, and Shape::normal_precision in src/objective/maps.rs.
float term_relief(Detail picture) {
    float xx = view_statistics.normal_xx;
    float xy = view_statistics.normal_xy;
    float yy = view_statistics.normal_yy;
    if (xx + yy < NORMAL_RIDGE) {
        return 0.0;
    }
    xx += NORMAL_RIDGE;
    yy += NORMAL_RIDGE;
    vec2 c = vec2(picture.covariance_x, picture.covariance_y);
    float explained = (yy * c.x * c.x - 2.0 * xy * c.x * c.y + xx * c.y * c.y) / (xx * yy - xy * xy);
    float share = explained / max(picture.irradiance_variance, RELIEF_LEAST);
    return 1.0 - clamp(share / RELIEF_ENOUGH, 0.0, 1.0);
}
