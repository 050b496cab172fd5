#include "shading.glsl"

// Reference: src/objective/mean_target.rs.
float mean_target() {
    if (parameters.mean_target != MEAN_OF_SCENE) {
        return parameters.mean_target;
    }
    float scene = srgb_encode(SCENE_MEAN_SHARE * view_statistics.base_luminance);
    return clamp(scene, SCENE_MEAN_LEAST, SCENE_MEAN_MOST);
}

// Reference: src/objective/terms/mean.rs.
float term_mean(Detail picture) {
    float target = mean_target();
    return abs(picture.mean - target) / max(target, 1.0 - target);
}
