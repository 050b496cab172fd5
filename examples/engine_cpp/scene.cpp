#include "scene.hpp"
#include <algorithm>

namespace {

constexpr float PI = 3.14159265f;

// A closed grid of points, seen from outside: `u` goes round, `v` goes over.
template <typename Point> Mesh grid(int columns, int rows, Point point) {
    Mesh mesh;
    for (int row = 0; row <= rows; ++row) {
        for (int column = 0; column <= columns; ++column) {
            auto [position, normal] = point(2 * PI * column / columns, PI * row / rows);
            mesh.positions.push_back(position);
            mesh.normals.push_back(normal);
        }
    }
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            uint32_t a = row * (columns + 1) + column, b = a + 1, c = a + columns + 1, d = c + 1;
            for (uint32_t index : {a, c, b, b, c, d}) mesh.indices.push_back(index);
        }
    }
    return mesh;
}

Mesh sphere() {
    return grid(40, 20, [](float u, float v) {
        Vec3 n{std::sin(v) * std::sin(u), std::cos(v), std::sin(v) * std::cos(u)};
        return std::pair(n, n);
    });
}

// Lies flat around the y axis; the ring's radius is 1.
Mesh torus(float thickness) {
    return grid(64, 24, [=](float u, float v) {
        Vec3 out{std::sin(u), 0, std::cos(u)};
        Vec3 n = std::cos(2 * v) * Vec3{0, 1, 0} + std::sin(2 * v) * out;
        return std::pair(out + thickness * n, n);
    });
}

// Stands on the ground, `half` its half width, height and half depth.
Mesh box(Vec3 half) {
    Mesh mesh;
    for (int side = 0; side < 6; ++side) {
        float sign = side % 2 ? 1.f : -1.f;
        Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        Vec3 n = sign * axes[side / 2], u = axes[(side / 2 + 1) % 3],
             v = sign * axes[(side / 2 + 2) % 3];
        uint32_t first = uint32_t(mesh.positions.size());
        for (auto [s, t] : {std::pair(-1.f, -1.f), {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
            Vec3 p = n + s * u + t * v;
            mesh.positions.push_back({half.x * p.x, half.y * (p.y + 1) / 2, half.z * p.z});
            mesh.normals.push_back(n);
        }
        for (uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
    }
    return mesh;
}

// Materials as the G-buffer's 8 bits hold them: sRGB colours, roughness and metallic factor in
// 255ths.
Material material(int red, int green, int blue, int roughness, int metallic) {
    auto linear = [](int code) {
        float x = code / 255.f;
        return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
    };
    return {{linear(red), linear(green), linear(blue)}, roughness / 255.f, metallic / 255.f};
}

// `object` with its lowest point at the origin, scaled and put somewhere on the floor.
Mat4 at(float x, float y, float z, float scale, float angle = 0) {
    Mat4 size;
    size.m[0] = size.m[5] = size.m[10] = scale;
    return translation({x, y, z}) * turn(angle) * size;
}

} // namespace

Scene make_scene() {
    Scene scene;
    scene.meshes = {box({2.7f, 0.1f, 2.1f}), box({0.5f, 1.3f, 0.5f}), box({0.7f, 0.5f, 0.4f}),
                    sphere(), torus(0.3f)};
    enum { FLOOR, PILLAR, BLOCK, SPHERE, TORUS };
    Material stone = material(190, 186, 178, 204, 0), clay = material(186, 92, 62, 153, 0);
    Material gold = material(226, 180, 92, 89, 255), jade = material(84, 150, 116, 77, 0);
    scene.objects = {
        {FLOOR, stone, at(0, -0.1f, 0, 1)},
        {PILLAR, clay, at(-1.6f, 0, -0.9f, 1, 0.5f)},
        {BLOCK, stone, at(1.3f, 0, -1.1f, 1, -0.4f)},
        {BLOCK, jade, at(1.4f, 0.5f, -1.1f, 0.6f, 0.3f)},
        {SPHERE, jade, at(-0.3f, 0.7f, -0.6f, 0.7f)},
        {SPHERE, gold, at(-1.1f, 0.4f, 0.9f, 0.4f)},
        {SPHERE, clay, at(1.9f, 0.35f, 0.7f, 0.35f)},
        {TORUS, gold, at(0.7f, 0.18f, 0.8f, 0.6f)},
    };

    Vec3 low{1e9f, 1e9f, 1e9f}, high = -1.f * low;
    auto each_vertex = [&](auto visit) {
        for (const Object& object : scene.objects) {
            for (Vec3 p : scene.meshes[object.mesh].positions) visit(object.world_from_object * p);
        }
    };
    each_vertex([&](Vec3 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    });
    scene.center = 0.5f * (low + high);
    each_vertex([&](Vec3 p) { scene.radius = std::max(scene.radius, length(p - scene.center)); });
    return scene;
}
