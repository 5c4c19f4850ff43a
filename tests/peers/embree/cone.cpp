// cone.cpp - open cones and cylinders, for which Embree has no geometry of its own.
#include "geometry.hpp"

#include <algorithm>

namespace {

// A cone with what every ray asks of it.
struct Side {
    Point base, axis; // unit
    float radius, slope, height;
};

struct Crossing {
    float distance;
    Point normal;
};

Side side_of(const Cone &cone) {
    const Point along = cone.top - cone.base;
    const float height = std::sqrt(dot(along, along));
    return {cone.base, along * (1 / height), cone.base_radius, (cone.top_radius - cone.base_radius) / height, height};
}

// The first crossing between `near` and `far`. The ray is looked at from where it passes the axis, so that little cancels;
// there f is its offset from the base across the axis, h along it, and r the side's radius at h.
bool intersect(const Side &s, Point origin, Point direction, float near, float far, Crossing &crossing) {
    const float climb = dot(direction, s.axis), change = s.slope * climb;
    const Point from_base = origin - s.base, across = direction - s.axis * climb;
    const float aside = dot(across, across);
    const float middle = aside > 1e-12f ? -dot(from_base, across) / aside : 0;
    const Point p = from_base + direction * middle;
    const float h = dot(p, s.axis), r = s.radius + s.slope * h;
    const Point f = p - s.axis * h;
    const float a = aside - change * change, b = change * r - dot(f, across), c = dot(f, f) - r * r;
    const float discriminant = b * b - a * c;
    if (discriminant < 0)
        return false;
    const float q = b + std::copysign(std::sqrt(discriminant), b);
    float first = q == 0 ? 0 : c / q, last = a == 0 ? first : q / a;
    if (first > last)
        std::swap(first, last);
    for (const float t : {first, last}) {
        const float height = h + climb * t;
        if (t + middle > near && t + middle < far && height >= 0 && height <= s.height) {
            const Point radial = f + across * t;
            crossing = {t + middle, radial - s.axis * (s.slope * (r + change * t))};
            return true;
        }
    }
    return false;
}

const Side &side(const void *sides, unsigned number) {
    return static_cast<const Side *>(sides)[number];
}

Point origin_of(RTCRayN *ray, unsigned n, unsigned k) {
    return {RTCRayN_org_x(ray, n, k), RTCRayN_org_y(ray, n, k), RTCRayN_org_z(ray, n, k)};
}

Point direction_of(RTCRayN *ray, unsigned n, unsigned k) {
    return {RTCRayN_dir_x(ray, n, k), RTCRayN_dir_y(ray, n, k), RTCRayN_dir_z(ray, n, k)};
}

bool intersect_lane(const Side &s, RTCRayN *ray, unsigned n, unsigned k, Crossing &crossing) {
    return intersect(s, origin_of(ray, n, k), direction_of(ray, n, k), RTCRayN_tnear(ray, n, k),
                     RTCRayN_tfar(ray, n, k), crossing);
}

void intersect_cone(const RTCIntersectFunctionNArguments *args) {
    const Side &s = side(args->geometryUserPtr, args->primID);
    RTCRayN *ray = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN *hit = RTCRayHitN_HitN(args->rayhit, args->N);
    for (unsigned k = 0; k < args->N; k++) {
        Crossing found;
        if (!args->valid[k] || !intersect_lane(s, ray, args->N, k, found))
            continue;
        RTCRayN_tfar(ray, args->N, k) = found.distance;
        RTCHitN_Ng_x(hit, args->N, k) = found.normal.x;
        RTCHitN_Ng_y(hit, args->N, k) = found.normal.y;
        RTCHitN_Ng_z(hit, args->N, k) = found.normal.z;
        RTCHitN_geomID(hit, args->N, k) = args->geomID;
        RTCHitN_primID(hit, args->N, k) = args->primID;
    }
}

void occlude_cone(const RTCOccludedFunctionNArguments *args) {
    const Side &s = side(args->geometryUserPtr, args->primID);
    for (unsigned k = 0; k < args->N; k++) {
        Crossing found;
        if (args->valid[k] && intersect_lane(s, args->ray, args->N, k, found))
            RTCRayN_tfar(args->ray, args->N, k) = -1;
    }
}

// How far a ring about a unit axis reaches along a coordinate where the axis has the component a.
float reach(float radius, float a) {
    return radius * std::sqrt(std::max(0.0f, 1 - a * a));
}

void bound_cone(const RTCBoundsFunctionArguments *args) {
    const Side &s = side(args->geometryUserPtr, args->primID);
    const Point top = s.base + s.axis * s.height;
    const float top_radius = s.radius + s.slope * s.height;
    RTCBounds &b = *args->bounds_o;
    b.lower_x = std::min(s.base.x - reach(s.radius, s.axis.x), top.x - reach(top_radius, s.axis.x));
    b.lower_y = std::min(s.base.y - reach(s.radius, s.axis.y), top.y - reach(top_radius, s.axis.y));
    b.lower_z = std::min(s.base.z - reach(s.radius, s.axis.z), top.z - reach(top_radius, s.axis.z));
    b.upper_x = std::max(s.base.x + reach(s.radius, s.axis.x), top.x + reach(top_radius, s.axis.x));
    b.upper_y = std::max(s.base.y + reach(s.radius, s.axis.y), top.y + reach(top_radius, s.axis.y));
    b.upper_z = std::max(s.base.z + reach(s.radius, s.axis.z), top.z + reach(top_radius, s.axis.z));
}

} // namespace

void set_cones(RTCGeometry geometry, const std::vector<Cone> &cones) {
    static std::vector<Side> sides; // for as long as the program runs
    for (const Cone &cone : cones)
        sides.push_back(side_of(cone));
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(sides.size()));
    rtcSetGeometryUserData(geometry, sides.data());
    rtcSetGeometryBoundsFunction(geometry, bound_cone, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_cone);
    rtcSetGeometryOccludedFunction(geometry, occlude_cone);
}
