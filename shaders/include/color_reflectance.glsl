// How a glTF material reflects in colour. The including shader declares the specialisation constant BRDF and,
// of it, GLTF. Reference: src/lighting/shading.rs.
#ifndef KLIEG_COLOR_REFLECTANCE
#define KLIEG_COLOR_REFLECTANCE

#include "color.glsl"

// What rough microfacets reflect at once of the light that a white metal reflects, by perceptual roughness and n.v.
float scattered_once(float roughness, float n_v) {
    vec3 powers = vec3(1.0, n_v, n_v * n_v);
    vec3 by_roughness = vec3(dot(SCATTERING_0, powers), dot(SCATTERING_1, powers), dot(SCATTERING_2, powers));
    float square = roughness * roughness;
    float lost = square * dot(by_roughness, vec3(1.0, roughness, square));
    return clamp(1.0 - lost, SCATTERED_LEAST, 1.0);
}

// Of glTF metallic-roughness, as Reflectance::coefficients. constants: ambient, dielectric, max_shininess.
ColorReflectance color_reflectance(
    vec3 base, float metallic, float roughness, vec3 emissive, float n_v, vec3 constants) {
    vec3 f0 = mix(vec3(constants.y), base, metallic);
    vec3 unlit = base * constants.x + emissive;
    vec3 diffuse = base * (1.0 - metallic);
    if (GLTF) {
        float wide = max(roughness, MIN_ROUGHNESS);
        if (BRDF == BRDF_GLTF_SCATTERING) {
            f0 += f0 * f0 * (1.0 / scattered_once(wide, n_v) - 1.0);
        }
        float alpha = wide * wide;
        return ColorReflectance(diffuse * (1.0 - constants.y), f0, alpha * alpha, unlit);
    }
    float s = shininess(roughness, constants.z);
    return ColorReflectance(diffuse, f0 * ((s + 8.0) / 8.0), 0.5 * s, unlit);
}

#endif
