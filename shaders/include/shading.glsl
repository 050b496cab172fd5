// Local illumination, the reference of src/lighting/shading.rs.
#ifndef KLIEG_SHADING
#define KLIEG_SHADING

#include "constants.glsl"

// Rec. 709 luminance of linear RGB.
float luminance(vec3 color) {
    return dot(color, LUMINANCE);
}

// The sRGB encoding (IEC 61966-2-1) of a linear value, clamped to 0..1.
float srgb_encode(float linear) {
    float x = clamp(linear, 0.0, 1.0);
    return x <= SRGB_LINEAR_END ? SRGB_SLOPE * x
                                : SRGB_SCALE * pow(x, 1.0 / SRGB_GAMMA) - SRGB_OFFSET;
}

// The linear value of an sRGB encoding (IEC 61966-2-1).
float srgb_decode(float encoded) {
    return encoded <= SRGB_ENCODED_END ? encoded / SRGB_SLOPE
                                       : pow((encoded + SRGB_OFFSET) / SRGB_SCALE, SRGB_GAMMA);
}

// How strongly a light acts on the diffuse and on the specular reflectance at p, as
// light_response of the reference. place: xyz position or direction, w its radius2; strength: diffuse
// and specular; n unit normal, v unit vector to the viewer.
vec2 light_response(vec4 place, vec2 strength, vec3 p, vec3 n, vec3 v, float shininess) {
    vec3 l = place.xyz;
    float falloff = 1.0;
    if (place.w > 0.0) {
        vec3 to_light = place.xyz - p;
        float inverse2 = 1.0 / dot(to_light, to_light);
        l = to_light * sqrt(inverse2);
        falloff = place.w * inverse2;
    }
    float n_l = dot(n, l);
    // (n . h)^2 of the unit half vector, without it: |l + v|^2 = 2 + 2 l . v.
    float along = max(n_l + dot(n, v), 0.0);
    float n_h2 = min(along * along / max(2.0 + 2.0 * dot(l, v), 1e-20), 1.0);
    float lit = n_l > 0.0 ? falloff * n_l : 0.0;
    return lit * strength * vec2(1.0, pow(n_h2, 0.5 * shininess));
}

// Blinn-Phong exponent of a perceptual roughness.
float shininess(float roughness, float most) {
    float alpha = roughness * roughness;
    // At roughness 0 the quotient would not be finite.
    return clamp(2.0 / max(alpha * alpha, 1e-30) - 2.0, 1.0, most);
}

struct Reflectance {
    float diffuse; // luminances
    float specular; // with its normalisation
    float shininess;
    float unlit;
};

// Of glTF metallic-roughness (glTF 2.0 specification, appendix B), as Shading::reflectance of the
// reference simplifies it.
Reflectance reflectance(vec3 base, float metallic, float roughness, vec3 emissive, vec3 constants) {
    float s = shininess(roughness, constants.z);
    vec3 specular = mix(vec3(constants.y), base, metallic) * ((s + 8.0) / 8.0);
    return Reflectance(luminance(base * (1.0 - metallic)), luminance(specular), s,
        luminance(base * constants.x + emissive));
}

#endif
