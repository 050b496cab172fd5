// Reference: src/objective/terms/edge.rs.
float term_edge(Detail picture) {
    return view_statistics.edge == 0 ? 0.0 : 1.0 - picture.edge_contrast;
}
