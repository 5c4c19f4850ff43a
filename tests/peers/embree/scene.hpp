// scene.hpp - a scene as NFF describes it, and a mesh beside it.
#pragma once

#include "vec.hpp"

#include <array>
#include <string>
#include <vector>

// Eight numbers, so that a packet gathers them from one array.
struct Material {
    Point diffuse;
    float ks, shine, t, ior, unused;
};

struct Light {
    Point position, colour;
};

// As Embree's RTC_FORMAT_FLOAT4 of a sphere.
struct Sphere {
    Point centre;
    float radius;
};

struct Cone {
    Point base;
    float base_radius;
    Point top;
    float top_radius;
};

using Triangle = std::array<unsigned, 3>;

// `materials` has one entry for each primitive, or one for all. `normals` are empty, or one per vertex.
struct Mesh {
    std::vector<Point> vertices, normals;
    std::vector<Triangle> triangles;
    std::vector<int> materials;
};

struct Scene {
    Point from{}, at{}, up{}, background{};
    float angle = 45; // degrees; spans the first to the last pixel's centre
    std::vector<Light> lights;
    std::vector<Material> materials;
    std::vector<Sphere> spheres;
    std::vector<int> sphere_materials;
    std::vector<Cone> cones;
    std::vector<int> cone_materials;
    Mesh flat, smooth; // polygons, and polygons with normals, as triangles
    Mesh file;         // from a mesh file, of the last material
};

// Each throws std::runtime_error that says what is wrong.
Scene read_nff(const std::string &path);
Mesh read_ply(const std::string &path);

// The whole of a file.
std::string read_file(const std::string &path);

// Cuts a planar polygon, convex or not, into triangles that turn as it does; indices count its corners.
std::vector<Triangle> triangulate(const std::vector<Point> &corners);
