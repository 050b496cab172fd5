// Reference: src/objective/terms/direction.rs.
float term_direction(Detail picture) {
    vec3 key = vec3(abs(picture.key_x), picture.key_y, picture.key_z);
    if (key == vec3(0.0)) {
        return 0.0;
    }
    float angle = acos(clamp(dot(key, DIRECTION_PREFERRED), -1.0, 1.0));
    return clamp((angle - DIRECTION_FREE) / (DIRECTION_MOST - DIRECTION_FREE), 0.0, 1.0);
}
