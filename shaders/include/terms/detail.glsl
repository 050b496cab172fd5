// Reference: src/objective/terms/detail.rs.
float term_detail(Detail picture) {
    return view_statistics.detail_weight > 0.0 ? 1.0 - min(picture.detail, 1.0) : 0.0;
}
