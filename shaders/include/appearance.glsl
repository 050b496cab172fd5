// Sums over what the lights do, pixel by pixel. References: src/cpu/appearance.rs, src/cpu/gradient.rs.
#ifndef KLIEG_APPEARANCE
#define KLIEG_APPEARANCE

#include "layout.glsl"
#include "shading.glsl"

// Sums over some pixels; the first irradiance is the origin of its sums, so that an even one deviates by
// exactly 0.
struct Sums {
    uint count;
    float origin;
    float sum;
    float squares;
    vec2 covariance;
    uint burnt;
    uint unlit;
    float residual;
    float detail;
    uint outline_count;
    float outline;
};

Sums no_sums() {
    return Sums(0, 0.0, 0.0, 0.0, vec2(0.0), 0, 0, 0.0, 0.0, 0, 0.0);
}

// Adds a pixel of the normal n; `value` is its encoded irradiance e, as -1 - e where it is burnt out.
void add_lights(float value, vec2 n, inout Sums sums) {
    bool burnt = value < 0.0;
    float e = burnt ? -1.0 - value : value;
    sums.origin = sums.count == 0 ? e : sums.origin;
    float distance = e - sums.origin;
    sums.count += 1;
    sums.sum += distance;
    sums.squares += distance * distance;
    sums.covariance += e * (n - view_statistics.normal_mean);
    sums.burnt += burnt ? 1 : 0;
    sums.unlit += e < srgb_encode(UNLIT) ? 1 : 0;
}

// Adds a SURFACE pixel where the picture's gradient is `slope` and the normals' is `gradient`.
void add_detail(float slope, float gradient, inout Sums sums) {
    float seen = min(slope / max(DETAIL_SHARE * gradient, DETAIL_LEAST), 1.0);
    sums.detail += min(gradient, DETAIL_MOST) * seen;
}

// Adds a pixel of a brightness where the target picture has another, or none.
void add_target(float brightness, float target, inout Sums sums) {
    float distance = target >= 0.0 ? brightness - target : 0.0;
    sums.residual += distance * distance;
}

// Whether an object pixel has a neighbour in the picture that shows the background.
bool is_outline(ivec2 pixel) {
    ivec2 last = ivec2(parameters.size) - 1;
    bool found = false;
    for (int k = 0; k < 9; ++k) {
        ivec2 at = clamp(pixel + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        found = found || type_at(at) == BACKGROUND;
    }
    return found;
}

// Adds a pixel of the outline.
void add_outline(float brightness, inout Sums sums) {
    sums.outline_count += 1;
    sums.outline += 1.0 - min(abs(brightness - parameters.background) / OUTLINE_ENOUGH, 1.0);
}

// What a pixel counts in the histogram by curvature, where the normals' gradient is `gradient`. Reference:
// src/objective/statistics.rs.
uint curvature_level(float gradient) {
    float most = max(CURVATURE_MOST * view_statistics.normal_detail, 1e-30);
    return uint(min(gradient / most, 1.0) * float(CURVATURE_LEVELS) + 0.5);
}

Appearance part_of(Sums sums) {
    float mean = sums.count > 0 ? sums.sum / float(sums.count) : 0.0;
    float deviation = max(sums.squares - sums.sum * mean, 0.0);
    return Appearance(sums.count, sums.count > 0 ? sums.origin + mean : 0.0, deviation,
        sums.covariance.x, sums.covariance.y, sums.burnt, sums.unlit, sums.residual, sums.detail,
        sums.outline_count, sums.outline);
}

#endif
