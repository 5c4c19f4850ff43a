// geometry.cpp
#include "geometry.hpp"

#include <chrono>

Geometry::Geometry(const Scene &scene) : device(rtcNewDevice(nullptr)), tree(rtcNewScene(device)) {
    add_spheres(scene);
    add_cones(scene);
    for (const Mesh *mesh : {&scene.flat, &scene.smooth, &scene.file})
        add_mesh(*mesh);
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(tree);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Geometry::~Geometry() {
    rtcReleaseScene(tree);
    rtcReleaseDevice(device);
}

void Geometry::add(RTCGeometry geometry, const std::vector<int> &materials, const Mesh *smooth, size_t primitives) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(tree, geometry, static_cast<unsigned>(groups.size()));
    rtcReleaseGeometry(geometry);
    groups.push_back({&materials, smooth});
    count += primitives;
}

void Geometry::add_spheres(const Scene &scene) {
    if (scene.spheres.empty())
        return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, scene.spheres.data(), 0,
                               sizeof(Sphere), scene.spheres.size());
    add(geometry, scene.sphere_materials, nullptr, scene.spheres.size());
}

void Geometry::add_cones(const Scene &scene) {
    if (scene.cones.empty())
        return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    set_cones(geometry, scene.cones);
    add(geometry, scene.cone_materials, nullptr, scene.cones.size());
}

void Geometry::add_mesh(const Mesh &mesh) {
    if (mesh.triangles.empty())
        return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.vertices.data(), 0,
                               sizeof(Point), mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               sizeof(Triangle), mesh.triangles.size());
    add(geometry, mesh.materials, mesh.normals.empty() ? nullptr : &mesh, mesh.triangles.size());
}
