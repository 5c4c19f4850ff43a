/* mesh_triangulate.c - faces of many corners cut into triangles by clipping ears.
 *
 * assimp 5.2 can do this too, but folds concave faces over themselves.
 */
#include "mesh_file.h"
#include "vec.h"

typedef struct point {
    double u, v;
} point;

/* A face seen along the axis that it faces most; counter-clockwise there. */
typedef struct outline {
    const vec3 *vertices;
    uint32_t *corners; /* those not yet clipped */
    size_t count;
    int axis;
    bool from_behind;
} outline;

static point seen(const outline *o, size_t corner) {
    vec3 p = o->vertices[o->corners[corner]];
    point at = o->axis == 0 ? (point){p.y, p.z} : o->axis == 1 ? (point){p.z, p.x} : (point){p.x, p.y};
    return o->from_behind ? (point){at.v, at.u} : at;
}

/* Newell's normal: right for concave and for slightly bent faces. */
static void choose_axis(outline *o) {
    vec3 normal = {0, 0, 0}, origin = o->vertices[o->corners[0]];
    for (size_t i = 0; i < o->count; i++) {
        vec3 a = vec_subtract(o->vertices[o->corners[i]], origin);
        vec3 b = vec_subtract(o->vertices[o->corners[(i + 1) % o->count]], origin);
        normal = vec_add(normal, vec_cross(a, b));
    }
    double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    o->axis = x > y && x > z ? 0 : y > z ? 1 : 2;
    o->from_behind = (o->axis == 0 ? normal.x : o->axis == 1 ? normal.y : normal.z) < 0;
}

/* Twice the area; positive when counter-clockwise. */
static double area(point a, point b, point c) {
    return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

static bool same(point a, point b) {
    return a.u == b.u && a.v == b.v;
}

/* Whether a corner of the outline, other than the three, lies in or on the triangle. */
static bool is_obstructed(const outline *o, point a, point b, point c) {
    for (size_t i = 0; i < o->count; i++) {
        point p = seen(o, i);
        if (!same(p, a) && !same(p, b) && !same(p, c) && area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0)
            return true;
    }
    return false;
}

/* The corner to clip: the first ear from `start` on. A face that crosses itself may have none; then the most convex corner, so
 * that it comes to an end. */
static size_t find_ear(const outline *o, size_t start) {
    size_t best = 0;
    double best_area = -HUGE_VAL;
    for (size_t k = 0; k < o->count; k++) {
        size_t i = (start + k) % o->count;
        point a = seen(o, (i + o->count - 1) % o->count), b = seen(o, i), c = seen(o, (i + 1) % o->count);
        double size = area(a, b, c);
        if (size > 0 && !is_obstructed(o, a, b, c))
            return i;
        if (size > best_area) {
            best_area = size;
            best = i;
        }
    }
    return best;
}

void mesh_triangulate(const vec3 *vertices, uint32_t *corners, size_t count, uint32_t *triangles) {
    outline o = {.vertices = vertices, .corners = corners, .count = count};
    if (count > 3)
        choose_axis(&o);
    for (size_t start = 0; o.count > 2; o.count--) {
        size_t i = o.count > 3 ? find_ear(&o, start) : 1;
        *triangles++ = corners[(i + o.count - 1) % o.count];
        *triangles++ = corners[i];
        *triangles++ = corners[(i + 1) % o.count];
        for (size_t k = i; k + 1 < o.count; k++)
            corners[k] = corners[k + 1];
        start = i; /* going on from the next corner keeps the triangles from being a needle-like fan */
    }
}
