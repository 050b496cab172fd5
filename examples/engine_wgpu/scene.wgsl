// The engine's shaders: one geometry, drawn into a G-buffer or as a lit picture.

const LIGHTS: u32 = 3u;

struct Light {
    // World position; w is the square of the distance at which the falloff is 1.
    position: vec4f,
    // Diffuse and specular intensity.
    intensity: vec4f,
}

struct Frame {
    clip_from_world: mat4x4f,
    eye: vec4f,
    lights: array<Light, LIGHTS>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) base_color: vec3f,
    // Roughness, metallic.
    @location(3) material: vec2f,
    @location(4) object: u32,
}

struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) base_color: vec3f,
    @location(3) material: vec2f,
    @location(4) @interpolate(flat) object: u32,
}

@vertex
fn project(vertex: Vertex) -> Fragment {
    return Fragment(
        frame.clip_from_world * vec4f(vertex.position, 1.0),
        vertex.position,
        vertex.normal,
        vertex.base_color,
        vertex.material,
        vertex.object,
    );
}

struct GBuffer {
    @location(0) normal: vec4f,
    @location(1) base_color: vec4f,
    // glTF's channels: roughness in green, metallic in blue.
    @location(2) roughness_metallic: vec4f,
    @location(3) object: u32,
}

@fragment
fn store(fragment: Fragment) -> GBuffer {
    return GBuffer(
        vec4f(normalize(fragment.normal), 0.0),
        vec4f(fragment.base_color, 1.0),
        vec4f(0.0, fragment.material, 1.0),
        fragment.object,
    );
}

// Lambert and Blinn-Phong under the lights and a sky, then a film curve.
@fragment
fn light(fragment: Fragment) -> @location(0) vec4f {
    let n = normalize(fragment.normal);
    let v = normalize(frame.eye.xyz - fragment.position);
    let alpha = fragment.material.x * fragment.material.x;
    let shininess = clamp(2.0 / (alpha * alpha) - 2.0, 1.0, 1024.0);
    let diffuse = fragment.base_color * (1.0 - fragment.material.y);
    let specular = mix(vec3f(0.04), fragment.base_color, fragment.material.y);
    var color = fragment.base_color * (0.05 + 0.03 * n.y);
    for (var i = 0u; i < LIGHTS; i++) {
        let light = frame.lights[i];
        let to_light = light.position.xyz - fragment.position;
        let distance2 = dot(to_light, to_light);
        let l = to_light * inverseSqrt(distance2);
        let h = normalize(l + v);
        let lobe = (shininess + 8.0) / 8.0 * pow(max(dot(n, h), 0.0), shininess);
        let strength = light.position.w / distance2 * max(dot(n, l), 0.0);
        color += strength * (light.intensity.x * diffuse + light.intensity.y * lobe * specular);
    }
    return vec4f(1.0 - exp(-1.6 * color), 1.0);
}
