// What a fragment of the scene's geometry looks like: the fragment shaders that draw it include this.
// Reference: src/cpu/visibility/.
#ifndef KLIEG_SURFACE
#define KLIEG_SURFACE

#include "visibility.glsl"

layout(set = 1, binding = 0) uniform sampler2D base_color_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D normal_texture;
layout(set = 1, binding = 3) uniform sampler2D emissive_texture;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec4 uv;
layout(location = 4) in vec4 color;
layout(location = 5) flat in uint instance;

struct Surface {
    vec3 normal; // unit length, turned to the viewer
    float metallic;
    vec3 base_color;
    float roughness;
    vec3 emissive;
    vec3 face; // the polygon's normal, unit length, turned to the viewer
};

// The texture coordinates' steps to the neighbouring pixels, both sets.
struct Steps {
    vec4 x;
    vec4 y;
};

// Trilinear, at the level whose texels are as large as the longer of the two pixel steps.
vec4 lookup(sampler2D map, TextureUse use, Steps steps) {
    bool first = use.u.w == 0.0;
    vec3 st = vec3(first ? uv.xy : uv.zw, 1.0);
    vec2 at = vec2(dot(use.u.xyz, st), dot(use.v.xyz, st));
    mat2 linear = transpose(mat2(use.u.xy, use.v.xy));
    vec2 size = vec2(textureSize(map, 0));
    vec2 dx = linear * (first ? steps.x.xy : steps.x.zw) * size;
    vec2 dy = linear * (first ? steps.y.xy : steps.y.zw) * size;
    float longer2 = max(max(dot(dx, dx), dot(dy, dy)), MIN_TEXEL_STEP2);
    return textureLod(map, at, 0.5 * log2(longer2));
}

// The unit vector `n` turned to the viewer. On the polygon's hidden side it changes sides; where
// interpolation or a texture bent it over the horizon it is mirrored back, which unlike a change of
// sides is continuous, so that outlines have no dark fringe.
vec3 turned(vec3 n, vec3 face, vec3 to_viewer) {
    n = dot(n, face) * dot(face, to_viewer) < 0.0 ? -n : n;
    return n - 2.0 * min(dot(n, to_viewer), 0.0) * to_viewer;
}

// The shading normal; `face` is the polygon's, of any length and sign.
vec3 shading_normal(MaterialRecord material, vec3 texel, vec3 face, vec3 to_viewer) {
    vec3 n = normal;
    if ((material.flags & NORMAL_MAPPED) != 0u) {
        vec3 t = 2.0 * texel - 1.0;
        vec3 bitangent = tangent.w * cross(normal, tangent.xyz);
        float scale = material.emissive_normal_scale.w;
        n = tangent.xyz * (t.x * scale) + bitangent * (t.y * scale) + normal * t.z;
    }
    return turned(unit_or(n, to_viewer), face, to_viewer);
}

// Discards the fragment where the material does not show.
Surface surface() {
    // Taken of what is interpolated alone: a pixel outside the polygon, which is computed only for
    // its neighbours' sake, need not get anything from memory.
    Steps steps = Steps(dFdxFine(uv), dFdyFine(uv));
    vec3 face = cross(dFdxFine(position), dFdyFine(position));
    InstanceRecord record = instances[instance];
    MaterialRecord material = materials[record.material];

    vec4 base =
        material.base_color * color * lookup(base_color_texture, material.textures[0], steps);
    bool front = gl_FrontFacing != (record.mirrored != 0u);
    bool shown = front || (material.flags & DOUBLE_SIDED) != 0u;
    if (!shown || base.a < material.alpha_cutoff) {
        discard;
    }
    vec4 metallic_roughness =
        lookup(metallic_roughness_texture, material.textures[1], steps);
    vec3 normal_texel = lookup(normal_texture, material.textures[2], steps).xyz;
    vec3 emissive =
        material.emissive_normal_scale.rgb * lookup(emissive_texture, material.textures[3], steps).rgb;
    vec3 to_viewer =
        eye.w == 1.0 ? vec3(0.0, 0.0, 1.0) : unit_or(eye.xyz - position, vec3(0.0, 0.0, 1.0));
    vec3 n = shading_normal(material, normal_texel, face, to_viewer);
    face = unit_or(dot(face, to_viewer) < 0.0 ? -face : face, to_viewer);
    return Surface(n, material.metallic * metallic_roughness.b, base.rgb,
        material.roughness * metallic_roughness.g, emissive, face);
}

#endif
