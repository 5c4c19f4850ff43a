// geometry.hpp - a scene as Embree sees it.
#pragma once

#include "embree.hpp"
#include "scene.hpp"

// What a geometry of the RTCScene is, by its number: the material of a primitive, and the mesh that has normals.
struct Group {
    const std::vector<int> *materials;
    const Mesh *smooth; // or null
};

// The scene must outlive it: Embree reads spheres, vertices and triangles where they are.
class Geometry {
  public:
    explicit Geometry(const Scene &scene);
    ~Geometry();
    Geometry(const Geometry &) = delete;
    Geometry &operator=(const Geometry &) = delete;

    RTCScene rtc() const {
        return tree;
    }
    const Group &group(unsigned geometry) const {
        return groups[geometry];
    }
    size_t primitives() const {
        return count;
    }
    double build_seconds() const {
        return seconds;
    }

  private:
    void add(RTCGeometry geometry, const std::vector<int> &materials, const Mesh *smooth, size_t primitives);
    void add_spheres(const Scene &scene);
    void add_cones(const Scene &scene);
    void add_mesh(const Mesh &mesh);

    RTCDevice device;
    RTCScene tree;
    std::vector<Group> groups;
    size_t count = 0;
    double seconds = 0;
};

// Makes `geometry`, of RTC_GEOMETRY_TYPE_USER, the cones' sides; Ng of a hit points outwards.
void set_cones(RTCGeometry geometry, const std::vector<Cone> &cones);
