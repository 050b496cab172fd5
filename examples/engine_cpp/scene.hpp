// What the engine shows: meshes, their materials, and where they stand. All of it is procedural.
#pragma once
#include "math.hpp"
#include <cstdint>
#include <vector>

struct Mesh {
    std::vector<Vec3> positions, normals;
    std::vector<uint32_t> indices; // three a triangle, counter-clockwise seen from outside
};

struct Material {
    Vec3 base_color; // linear
    float roughness, metallic;
};

struct Object {
    uint32_t mesh;
    Material material;
    Mat4 world_from_object;
};

struct Scene {
    std::vector<Mesh> meshes;
    std::vector<Object> objects;
    // Centre of the bounding box of all vertices, and their largest distance from it.
    Vec3 center;
    float radius = 0;
};

// A floor with boxes, spheres and a torus.
Scene make_scene();
