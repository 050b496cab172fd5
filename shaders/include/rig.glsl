// The lights of an individual on their way from the vertices to the fragments of its picture: flat
// varyings, so that no fragment reads them from memory. The including shader defines RIG_LOCATION,
// the first of their MAX_LIGHTS * 3 / 2 locations, and, where it is a vertex shader, RIG_OUT.
#ifndef KLIEG_RIG
#define KLIEG_RIG

#include "constants.glsl"
#include "light.glsl"
#include "shading.glsl"

layout(constant_id = 0) const uint LIGHTS = 1;

#ifdef RIG_OUT

layout(location = RIG_LOCATION) flat out vec4 rig_places[MAX_LIGHTS];
layout(location = RIG_LOCATION + MAX_LIGHTS) flat out vec4 rig_strengths[MAX_LIGHTS / 2]; // two lights each

void pass_light(uint i, Light light) {
    rig_places[i] = vec4(light.position, light.radius2);
    if ((i & 1) == 0) {
        rig_strengths[i / 2] = vec4(light.diffuse, light.specular, 0.0, 0.0);
    } else {
        rig_strengths[i / 2].zw = vec2(light.diffuse, light.specular);
    }
}

#else

layout(location = RIG_LOCATION) flat in vec4 rig_places[MAX_LIGHTS];
layout(location = RIG_LOCATION + MAX_LIGHTS) flat in vec4 rig_strengths[MAX_LIGHTS / 2];

// Encoded brightness at p; n unit normal, v unit vector to the viewer.
float lit(vec3 p, vec3 n, vec3 v, Reflectance looks) {
    vec2 response = vec2(0.0);
    for (uint i = 0; i < LIGHTS; ++i) {
        vec4 pair = rig_strengths[i / 2];
        vec2 strength = (i & 1) == 0 ? pair.xy : pair.zw;
        response += light_response(rig_places[i], strength, p, n, v, looks.shininess);
    }
    return srgb_encode(looks.unlit + response.x * looks.diffuse + response.y * looks.specular);
}

#endif

#endif
