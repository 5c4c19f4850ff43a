// trace.hpp - Whitted's ray tree for N rays that travel together: one ray, or a pixel's 16 samples as a packet.
#pragma once

#include "geometry.hpp"

#include <cfloat>

constexpr int most_depth = 5; // the eye ray's is 1

struct Counts {
    long eye = 0, eye_hits = 0, reflection = 0, transmission = 0, shadow = 0;
};

template <int N> struct Packet {
    Vec<Reals<N>> origin, direction;
    Reals<N> weight;
    Ints<N> active;
};

// Of lanes that hit nothing only `found` means anything. `normal` has any length.
template <int N> struct Hits {
    Ints<N> found, geometry, primitive;
    Reals<N> distance, u, v;
    Vec<Reals<N>> normal;
};

// Where a ray met a surface; both normals are turned to the ray's side. A new ray starts `offset` beside the point.
template <int N> struct Surface {
    Vec<Reals<N>> point, normal, shading;
    Reals<N> offset;
    Ints<N> entering;
    Vec<Reals<N>> diffuse;
    Reals<N> ks, shine, t, ior;
};

// What one thread traces with.
struct Tracer {
    const Scene &scene;
    const Geometry &geometry;
    Queries queries;
    Counts counts;
};

inline Hits<1> find_closest(Tracer &tracer, const Packet<1> &p) {
    RTCRayHit q;
    q.ray = {p.origin.x, p.origin.y, p.origin.z, 0, p.direction.x, p.direction.y, p.direction.z, 0, FLT_MAX, ~0u, 0, 0};
    q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    tracer.queries.closest(tracer.geometry.rtc(), q);
    return {q.hit.geomID != RTC_INVALID_GEOMETRY_ID,
            static_cast<int>(q.hit.geomID),
            static_cast<int>(q.hit.primID),
            q.ray.tfar,
            q.hit.u,
            q.hit.v,
            {q.hit.Ng_x, q.hit.Ng_y, q.hit.Ng_z}};
}

// Embree's arrays of 16 are vectors of ours.
template <class T> inline Reals<16> &reals_at(T *array) {
    return *reinterpret_cast<Reals<16> *>(array);
}
inline Ints<16> &ints_at(unsigned *array) {
    return *reinterpret_cast<Ints<16> *>(array);
}

inline void set_rays(RTCRay16 &rays, const Vec<Reals<16>> &origin, const Vec<Reals<16>> &direction, Reals<16> far) {
    reals_at(rays.org_x) = origin.x, reals_at(rays.org_y) = origin.y, reals_at(rays.org_z) = origin.z;
    reals_at(rays.dir_x) = direction.x, reals_at(rays.dir_y) = direction.y, reals_at(rays.dir_z) = direction.z;
    reals_at(rays.tnear) = reals_at(rays.time) = Reals<16>{};
    reals_at(rays.tfar) = far;
    ints_at(rays.mask) = Ints<16>{} - 1;
    ints_at(rays.flags) = Ints<16>{};
}

inline Hits<16> find_closest(Tracer &tracer, const Packet<16> &p) {
    RTCRayHit16 q;
    set_rays(q.ray, p.origin, p.direction, Reals<16>{} + FLT_MAX);
    ints_at(q.hit.geomID) = ints_at(q.hit.instID[0]) = Ints<16>{} - 1; // RTC_INVALID_GEOMETRY_ID
    tracer.queries.closest(tracer.geometry.rtc(), as_array(p.active), q);
    const Ints<16> geometry = ints_at(q.hit.geomID);
    return {p.active & (geometry != -1),
            geometry,
            ints_at(q.hit.primID),
            reals_at(q.ray.tfar),
            reals_at(q.hit.u),
            reals_at(q.hit.v),
            {reals_at(q.hit.Ng_x), reals_at(q.hit.Ng_y), reals_at(q.hit.Ng_z)}};
}

// Which of the active feelers meet nothing before `far`.
inline Ints<1> find_free(Tracer &tracer, Vec<float> o, Vec<float> d, float far, Ints<1> active) {
    RTCRay q = {o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, far, ~0u, 0, 0};
    if (active)
        tracer.queries.occluded(tracer.geometry.rtc(), q);
    return active & (q.tfar >= 0);
}

inline Ints<16> find_free(Tracer &tracer, Vec<Reals<16>> o, Vec<Reals<16>> d, Reals<16> far, Ints<16> active) {
    RTCRay16 q;
    set_rays(q, o, d, far);
    tracer.queries.occluded(tracer.geometry.rtc(), as_array(active), q);
    return active & (reals_at(q.tfar) >= 0);
}

template <int N> Ints<N> find_materials(const Tracer &tracer, const Hits<N> &h) {
    Ints<N> numbers{};
    for (int k = 0; k < N; k++)
        if (as_array(h.found)[k]) {
            const std::vector<int> &all = *tracer.geometry.group(as_array(h.geometry)[k]).materials;
            as_array(numbers)[k] = all.size() == 1 ? all[0] : all[as_array(h.primitive)[k]];
        }
    return numbers;
}

template <int N> Reals<N> gather(const float *column, const Ints<N> &rows) {
    Reals<N> values;
    for (int k = 0; k < N; k++)
        as_array(values)[k] = column[as_array(rows)[k] * static_cast<int>(sizeof(Material) / sizeof(float))];
    return values;
}

// Interpolated normals, where there are some, kept on the ray's side.
template <int N> void interpolate_normals(const Tracer &tracer, const Hits<N> &h, Vec<Reals<N>> v, Surface<N> &s) {
    Ints<N> smooth{};
    Vec<Reals<N>> normal = s.normal;
    for (int k = 0; k < N; k++) {
        const Mesh *mesh = as_array(h.found)[k] ? tracer.geometry.group(as_array(h.geometry)[k]).smooth : nullptr;
        if (!mesh)
            continue;
        const float b = as_array(h.u)[k], c = as_array(h.v)[k];
        const Triangle &corner = mesh->triangles[as_array(h.primitive)[k]];
        const Point n =
            mesh->normals[corner[0]] * (1 - b - c) + mesh->normals[corner[1]] * b + mesh->normals[corner[2]] * c;
        as_array(smooth)[k] = -1;
        as_array(normal.x)[k] = n.x, as_array(normal.y)[k] = n.y, as_array(normal.z)[k] = n.z;
    }
    normal = unit(choose(s.entering, normal, -normal));
    const Reals<N> height = dot(normal, v);
    normal = choose(height > 0, normal, unit(normal + v * (0x1p-10f - height)));
    s.shading = choose(smooth, normal, s.normal);
}

template <int N> Surface<N> find_surface(const Tracer &tracer, const Packet<N> &p, const Hits<N> &h) {
    Surface<N> s;
    s.point = p.origin + p.direction * h.distance;
    s.normal = unit(h.normal);
    s.entering = dot(s.normal, p.direction) < 0;
    s.normal = s.shading = choose(s.entering, s.normal, -s.normal);
    s.offset = larger(extent(s.point), h.distance) * 0x1p-19f; // some 16 roundings of the largest number in it
    if (!tracer.scene.smooth.triangles.empty() || !tracer.scene.file.normals.empty())
        interpolate_normals(tracer, h, -p.direction, s);
    const Ints<N> row = find_materials(tracer, h);
    const Material *table = tracer.scene.materials.data();
    s.diffuse = {gather<N>(&table->diffuse.x, row), gather<N>(&table->diffuse.y, row),
                 gather<N>(&table->diffuse.z, row)};
    s.ks = gather<N>(&table->ks, row), s.shine = gather<N>(&table->shine, row);
    s.t = gather<N>(&table->t, row), s.ior = gather<N>(&table->ior, row);
    return s;
}

// A direction that leaves the surface on the side of n, whatever rounding and interpolated normals did.
template <class T> Vec<T> keep_above(Vec<T> direction, Vec<T> n) {
    const T height = dot(direction, n);
    return choose(height > 0, direction, unit(direction + n * (0x1p-10f - height)));
}

template <int N>
void add_light(Tracer &tracer, const Light &light, const Surface<N> &s, Vec<Reals<N>> mirrored, Reals<N> weight,
               Ints<N> active, Vec<Reals<N>> &sum) {
    using T = Reals<N>;
    const Vec<T> to_light = splat<T>(light.position) - s.point;
    const T distance = square_root(dot(to_light, to_light));
    const Vec<T> direction = to_light * (1 / distance);
    const T cosine = dot(s.shading, direction), shine = dot(mirrored, direction);
    const Ints<N> shines = (s.ks > 0) & (shine > 0);
    active = active & (cosine > 0) & (dot(s.normal, direction) > 0) & ((extent(s.diffuse) > 0) | shines);
    if (!any_lane(active))
        return;
    tracer.counts.shadow += count_lanes(active);
    const Vec<T> origin = s.point + s.normal * s.offset;
    const Ints<N> free = find_free(tracer, origin, direction, distance * (1 - 0x1p-18f), active);
    if (!any_lane(free))
        return;
    T highlight{};
    if (any_lane(free & shines))
        highlight = choose(shines, s.ks * power(choose(shines, shine, T{} + 1), s.shine), T{});
    const Vec<T> colour = {(s.diffuse.x * cosine + highlight) * light.colour.x,
                           (s.diffuse.y * cosine + highlight) * light.colour.y,
                           (s.diffuse.z * cosine + highlight) * light.colour.z};
    sum = sum + choose(free, colour * weight, Vec<T>{}); // lanes without a surface hold anything
}

template <int N> void trace(Tracer &tracer, const Packet<N> &p, int depth, Vec<Reals<N>> &sum);

template <int N>
void transmit(Tracer &tracer, const Packet<N> &p, const Surface<N> &s, Ints<N> active, int depth, Vec<Reals<N>> &sum) {
    const Reals<N> eta = choose(s.entering, 1 / s.ior, s.ior);
    const Vec<Reals<N>> parallel = (p.direction - s.shading * dot(p.direction, s.shading)) * eta;
    const Reals<N> squared = dot(parallel, parallel);
    Packet<N> next;
    next.active = active & (s.t > 0) & (squared < 1);
    if (!any_lane(next.active))
        return;
    tracer.counts.transmission += count_lanes(next.active);
    const Reals<N> upright = square_root(choose(next.active, 1 - squared, Reals<N>{}));
    next.direction = keep_above(parallel - s.shading * upright, -s.normal);
    next.origin = s.point - s.normal * s.offset;
    next.weight = p.weight * s.t;
    trace<N>(tracer, next, depth + 1, sum);
}

// Adds what the rays of the packet, of which at least one is active, bring to `sum`.
template <int N> void trace(Tracer &tracer, const Packet<N> &p, int depth, Vec<Reals<N>> &sum) {
    const Hits<N> h = find_closest(tracer, p);
    const Reals<N> missed = choose(p.active & !h.found, p.weight, Reals<N>{});
    sum = sum + splat<Reals<N>>(tracer.scene.background) * missed;
    if (depth == 1)
        tracer.counts.eye_hits += count_lanes(h.found);
    if (!any_lane(h.found))
        return;
    const Surface<N> s = find_surface(tracer, p, h);
    const Vec<Reals<N>> mirrored = p.direction - s.shading * (2 * dot(s.shading, p.direction));
    Packet<N> next;
    next.direction = keep_above(mirrored, s.normal);
    for (const Light &light : tracer.scene.lights)
        add_light<N>(tracer, light, s, next.direction, p.weight, h.found, sum);
    if (depth == most_depth)
        return;
    next.active = h.found & (s.ks > 0);
    if (any_lane(next.active)) {
        tracer.counts.reflection += count_lanes(next.active);
        next.origin = s.point + s.normal * s.offset;
        next.weight = p.weight * s.ks;
        trace<N>(tracer, next, depth + 1, sum);
    }
    if (any_lane(h.found & (s.t > 0)))
        transmit<N>(tracer, p, s, h.found, depth, sum);
}
