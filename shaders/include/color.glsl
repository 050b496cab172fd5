// Local illumination in colour, for any light and either BRDF. The including shader declares the
// specialisation constant GLTF, and what shadow.glsl asks for. Reference: src/lighting/shading.rs.
#ifndef KLIEG_COLOR
#define KLIEG_COLOR

#include "light.glsl"
#include "shadow.glsl"
#include "shading.glsl"

// How a point reflects. Of Blinn-Phong: the specular reflectance with its normalisation, and half the
// exponent; of glTF: the diffuse reflectance below the dielectric's surface, the reflectance at normal
// incidence, and alpha squared.
struct ColorReflectance {
    vec3 diffuse;
    vec3 specular;
    float lobe;
    vec3 unlit;
};

// What the lights have done so far.
struct Lit {
    vec3 radiance; // towards the viewer
    float irradiance; // diffuse; 1 where a white matt surface would show white
};

// Half of the height-correlated Smith function's denominator.
float masking(float a, float b, float alpha2) {
    return a * sqrt(b * b * (1.0 - alpha2) + alpha2);
}

// Adds what a light does at p, which a pixel shows; n unit normal, v unit vector to the viewer.
void add_light(Light light, ivec2 pixel, vec3 p, vec3 n, vec3 v, ColorReflectance looks, inout Lit lit) {
    vec3 l = light.position;
    float falloff = 1.0;
    if (light.radius2 > 0.0) {
        vec3 to_light = light.position - p;
        float inverse2 = 1.0 / dot(to_light, to_light);
        l = to_light * sqrt(inverse2);
        falloff = light.radius2 * inverse2;
    }
    float n_l = dot(n, l);
    if (!(n_l > 0.0)) {
        return;
    }
    float cone = clamp(light.cone_offset - dot(light.axis, l) * light.cone_scale, 0.0, 1.0);
    float received = falloff * n_l * cone * cone;
    if (SHADOW_SIDE > 0) {
        received *= light_visibility(light, pixel, p, l);
    }
    vec3 h = l + v;
    float length2 = max(dot(h, h), 1e-20);
    float n_v = dot(n, v);
    float along = max(n_l + n_v, 0.0);
    float n_h2 = along * along / length2;
    vec3 diffuse = looks.diffuse;
    vec3 specular = looks.specular;
    if (GLTF) {
        float miss = clamp(1.0 - 0.5 * sqrt(length2), 0.0, 1.0);
        float grazing = (miss * miss) * (miss * miss) * miss;
        vec3 fresnel = mix(looks.specular, vec3(1.0), grazing);
        // By way of the sine: it keeps the precision that 1 - cosine squared would lose.
        vec3 across = cross(n, h);
        float spread = n_h2 * looks.lobe + dot(across, across) / length2;
        n_v = max(n_v, 1e-4);
        float visibility = 0.5 / (masking(n_l, n_v, looks.lobe) + masking(n_v, n_l, looks.lobe));
        diffuse *= 1.0 - grazing;
        specular = fresnel * (looks.lobe / (spread * spread) * visibility);
    } else {
        specular *= pow(min(n_h2, 1.0), looks.lobe);
    }
    lit.radiance += received * light.color * (diffuse * light.diffuse + specular * light.specular);
    lit.irradiance += received * light.diffuse;
}

// The brightness I, and the encoded irradiance e, as -1 - e where a channel is burnt out.
vec2 encoded(Lit lit) {
    float e = srgb_encode(lit.irradiance);
    float most = max(lit.radiance.r, max(lit.radiance.g, lit.radiance.b));
    bool burnt = most >= srgb_decode(BURNT);
    return vec2(srgb_encode(luminance(lit.radiance)), burnt ? -1.0 - e : e);
}

#endif
