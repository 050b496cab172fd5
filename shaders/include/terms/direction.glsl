// Reference: src/objective/terms/direction.rs.
float term_direction(Detail picture) {
    const vec3 PREFERRED = vec3(0.49673176, 0.5, 0.7094065);
    const float FREE = radians(15.0);
    const float MOST = radians(75.0);
    vec3 key = vec3(abs(picture.key_x), picture.key_y, picture.key_z);
    if (key == vec3(0.0)) {
        return 0.0;
    }
    float angle = acos(clamp(dot(key, PREFERRED), -1.0, 1.0));
    return clamp((angle - FREE) / (MOST - FREE), 0.0, 1.0);
}
