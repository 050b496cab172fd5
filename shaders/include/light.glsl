// A light as the host writes it; the Rust side is LightRecord in src/lighting/.
#ifndef KLIEG_LIGHT
#define KLIEG_LIGHT

struct Light {
    vec3 position; // of a point light, or the unit direction towards a directional one
    float radius2; // R * R of a point light; 0 marks a directional one
    float diffuse;
    float specular;
    vec2 padding;
};

#endif
