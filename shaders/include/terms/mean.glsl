#include "shading.glsl"

// Reference: src/objective/mean_target.rs.
float unmoved_mean_target() {
    if (parameters.mean_target != MEAN_OF_SCENE) {
        return parameters.mean_target;
    }
    float scene = srgb_encode(SCENE_MEAN_SHARE * view_statistics.base_luminance);
    return clamp(scene, SCENE_MEAN_LEAST, SCENE_MEAN_MOST);
}

// Reference: Objective::mean_of.
float mean_target() {
    float target = unmoved_mean_target();
    if (parameters.mean_stops == 0.0) {
        return target;
    }
    float moved = srgb_encode(srgb_decode(target) * exp2(parameters.mean_stops));
    return clamp(moved, MEAN_LEAST, MEAN_MOST);
}

// Reference: src/objective/terms/mean.rs.
float term_mean(Detail picture) {
    float target = mean_target();
    return abs(picture.mean - target) / max(target, 1.0 - target);
}
