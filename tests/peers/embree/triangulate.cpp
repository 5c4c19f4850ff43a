// triangulate.cpp - polygons cut into triangles by clipping ears.
#include "scene.hpp"

namespace {

struct Place {
    double u, v;
};

double area(Place a, Place b, Place c) {
    return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

// Newell's normal: right for concave polygons too.
Vec<double> normal_of(const std::vector<Point> &corners) {
    Vec<double> sum{};
    for (size_t i = 0; i < corners.size(); i++) {
        const Point a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
        sum = sum + cross(Vec<double>{a.x, a.y, a.z}, Vec<double>{b.x, b.y, b.z});
    }
    return sum;
}

// The polygon seen along the axis that it faces most, counter-clockwise.
std::vector<Place> flatten(const std::vector<Point> &corners) {
    const Vec<double> n = normal_of(corners);
    const double x = std::fabs(n.x), y = std::fabs(n.y), z = std::fabs(n.z);
    const int axis = x > y && x > z ? 0 : y > z ? 1 : 2;
    const bool behind = (axis == 0 ? n.x : axis == 1 ? n.y : n.z) < 0;
    std::vector<Place> places;
    for (const Point &p : corners) {
        const Place q = axis == 0 ? Place{p.y, p.z} : axis == 1 ? Place{p.z, p.x} : Place{p.x, p.y};
        places.push_back(behind ? Place{q.v, q.u} : q);
    }
    return places;
}

bool is_ear(const std::vector<Place> &places, const std::vector<unsigned> &left, size_t i) {
    const size_t count = left.size();
    const unsigned ia = left[(i + count - 1) % count], ib = left[i], ic = left[(i + 1) % count];
    const Place a = places[ia], b = places[ib], c = places[ic];
    if (!(area(a, b, c) > 0))
        return false;
    for (unsigned k : left) {
        const Place p = places[k];
        const bool inside = area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0;
        if (k != ia && k != ib && k != ic && inside)
            return false;
    }
    return true;
}

} // namespace

std::vector<Triangle> triangulate(const std::vector<Point> &corners) {
    std::vector<Triangle> triangles;
    std::vector<unsigned> left;
    for (unsigned i = 0; i < corners.size(); i++)
        left.push_back(i);
    const std::vector<Place> places = flatten(corners);
    for (size_t start = 0; left.size() > 2;) {
        size_t i = start % left.size();
        for (size_t tried = 0; left.size() > 3 && tried < left.size() && !is_ear(places, left, i); tried++)
            i = (i + 1) % left.size(); // none at all: the polygon crosses itself, and any corner will do
        const size_t count = left.size();
        triangles.push_back({left[(i + count - 1) % count], left[i], left[(i + 1) % count]});
        left.erase(left.begin() + static_cast<long>(i));
        start = i;
    }
    return triangles;
}
