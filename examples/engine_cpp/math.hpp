// Vectors and matrices, as far as the engine needs them. Matrices are stored column after column.
#pragma once
#include <array>
#include <cmath>

struct Vec3 {
    float x = 0, y = 0, z = 0;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalize(Vec3 a) { return 1 / length(a) * a; }
inline Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Mat4 {
    std::array<float, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};

inline Mat4 operator*(const Mat4& a, const Mat4& b) {
    Mat4 product;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            float& sum = product.m[4 * column + row] = 0;
            for (int k = 0; k < 4; ++k) sum += a.m[4 * k + row] * b.m[4 * column + k];
        }
    }
    return product;
}

// A position transformed by an affine matrix.
inline Vec3 operator*(const Mat4& a, Vec3 p) {
    const auto& m = a.m;
    return Vec3{m[12], m[13], m[14]} + p.x * Vec3{m[0], m[1], m[2]} + p.y * Vec3{m[4], m[5], m[6]} +
           p.z * Vec3{m[8], m[9], m[10]};
}

inline Mat4 translation(Vec3 to) {
    Mat4 a;
    a.m[12] = to.x, a.m[13] = to.y, a.m[14] = to.z;
    return a;
}

// About the y axis, radians.
inline Mat4 turn(float angle) {
    Mat4 a;
    a.m[0] = a.m[10] = std::cos(angle);
    a.m[8] = std::sin(angle), a.m[2] = -a.m[8];
    return a;
}

// Eye space from world space: right-handed, y up, the view goes along -z.
inline Mat4 look_at(Vec3 eye, Vec3 at) {
    Vec3 back = normalize(eye - at);
    Vec3 up = std::fabs(back.y) > 0.99f ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    Vec3 right = normalize(cross(up, back));
    up = cross(back, right);
    return {{right.x, up.x, back.x, 0, right.y, up.y, back.y, 0, right.z, up.z, back.z, 0,
             -dot(right, eye), -dot(up, eye), -dot(back, eye), 1}};
}

// Vulkan's clip space (y down) with reversed depth: 1 at the near plane, 0 at infinity.
inline Mat4 perspective(float vertical_angle, float aspect, float near) {
    float f = 1 / std::tan(vertical_angle / 2);
    return {{f / aspect, 0, 0, 0, 0, -f, 0, 0, 0, 0, 0, -1, 0, 0, near, 0}};
}

// A parallel projection of a cube of the given half width around the eye, with reversed depth.
inline Mat4 parallel(float half) {
    return {{1 / half, 0, 0, 0, 0, -1 / half, 0, 0, 0, 0, 0.5f / half, 0, 0, 0, 0.5f, 1}};
}
