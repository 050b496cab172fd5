// A light as the host writes it; the Rust side is LightRecord in src/lighting/.
#ifndef KLIEG_LIGHT
#define KLIEG_LIGHT

struct Light {
    vec3 position; // or the unit direction towards a directional light
    float radius2; // R * R; 0 marks a directional light
    float diffuse;
    float specular;
    float cone_scale; // a spot's angular falloff is clamp(cosine * scale + offset, 0, 1) squared
    float cone_offset;
    vec3 color; // linear RGB of luminance 1
    float size;
    vec3 axis; // unit vector along a spot's cone, away from the light
    float key; // 1 for a key light
};

#endif
