// block.cl - a leaf's primitives, all of one kind.
//
// One ray meets as many of them at a time as there are lanes (TOGETHER), many rays meet one after another: the same
// functions with other things in the lanes.
#define TOGETHER true
#define APART false

vectors load_rows(global const real *rows, uint k) {
    return make_vectors(load_row(rows, k), load_row(rows + WIDTH, k), load_row(rows + 2 * WIDTH, k));
}

// A field of the entries k, k + 1, ..., or of entry k for every ray.
reals load_field(global const real *block, uint field, uint k, bool together) {
    return together ? load_row(block + field * WIDTH, k) : splat(block[field * WIDTH + k]);
}

vectors load_fields(global const real *block, uint field, uint k, bool together) {
    return make_vectors(load_field(block, field, k, together), load_field(block, field + 1, k, together),
                        load_field(block, field + 2, k, together));
}

ints load_numbers(global const uint *numbers, uint k, bool together) {
    if (!together)
        return whole(numbers[k]);
    ints n;
    for (int lane = 0; lane < LANES; lane++)
        INT_LANE(n, lane) = numbers[k + lane % CHUNK];
    return n;
}

// The nearest of the lanes' crossings where one ray meets many, in every lane.
hit nearest_lane(hit best, ints better, crossing c, ints numbers) {
    real distance = REAL_LANE(best.distance, 0), u = REAL_LANE(best.u, 0), v = REAL_LANE(best.v, 0);
    integer number = INT_LANE(best.primitive, 0);
    for (uint bits = lane_bits(better); bits != 0; bits &= bits - 1) {
        const uint k = lowest_bit(bits);
        const real other = REAL_LANE(c.distance, k);
        if (other < distance || (other == distance && INT_LANE(numbers, k) < number)) {
            distance = other;
            number = INT_LANE(numbers, k);
            u = REAL_LANE(c.u, k);
            v = REAL_LANE(c.v, k);
        }
    }
    best.distance = splat(distance);
    best.primitive = whole(number);
    best.u = splat(u);
    best.v = splat(v);
    return best;
}

#if HAS_CONE
frustum load_frustum(global const real *block, uint k, bool together) {
    frustum f;
    f.base = load_fields(block, 6, k, together);
    f.frame.x = load_fields(block, 9, k, together);
    f.frame.y = load_fields(block, 12, k, together);
    f.frame.z = load_fields(block, 15, k, together);
    f.radius = load_field(block, 18, k, together);
    f.height = load_field(block, 19, k, together);
    f.slope = load_field(block, 20, k, together);
    return f;
}
#endif

typedef struct {
    vectors low, high;
} boxes;

// The entries' bounds, which a block begins with, unless they are plain from its triangles.
INLINE boxes load_boxes(global const real *block, uint kind, uint k, bool together) {
    boxes b;
#if HAS_TRIANGLE
    if (kind == KIND_TRIANGLE) {
        const vectors v0 = load_fields(block, 0, k, together), v1 = load_fields(block, 3, k, together),
                      v2 = load_fields(block, 6, k, together);
        b.low = least_xyz(least_xyz(v0, v1), v2);
        b.high = greatest_xyz(greatest_xyz(v0, v1), v2);
        return b;
    }
#endif
    b.low = load_fields(block, 0, k, together);
    b.high = load_fields(block, 3, k, together);
    return b;
}

INLINE crossing cross_entries(ray r, global const real *block, uint kind, uint flags, uint k, bool together) {
    switch (kind) {
#if HAS_SPHERE
    case KIND_SPHERE:
        return intersect_sphere(r, load_fields(block, 6, k, together), load_field(block, 9, k, together), flags);
#endif
#if HAS_DISC
    case KIND_DISC:
        return intersect_disc(r, load_fields(block, 6, k, together), load_fields(block, 10, k, together),
                              load_field(block, 9, k, together), flags);
#endif
#if HAS_BOX
    case KIND_BOX:
        return intersect_box(r, load_fields(block, 0, k, together), load_fields(block, 3, k, together), flags);
#endif
#if HAS_TRIANGLE
    case KIND_TRIANGLE:
        return intersect_triangle(r, load_fields(block, 0, k, together), load_fields(block, 3, k, together),
                                  load_fields(block, 6, k, together), flags);
#endif
#if HAS_CONE
    case KIND_CONE:
        return intersect_cone(r, load_frustum(block, k, together), flags);
#endif
    default: {
        const crossing none = {mask(false), splat(0), splat(0), splat(0)};
        return none;
    }
    }
}

#if HAS_POLYGON
// Polygons have too many corners to go side by side: always apart. Their edges come last.
INLINE hit try_polygon(const scene *s, const ray *around, ints active, hit best, global const real *block,
                       global const uint *numbers, uint flags, uint k, bool together) {
    const ints number = whole(numbers[k]);
    const ray r = face_primitive(*around, number);
    const uint index = s->primitives[numbers[k]].y;
    const polygon p = s->polygons[index];
    const boxes b = load_boxes(block, KIND_POLYGON, k, APART);
    crossing c = intersect_plane(r, splat_xyz(p.point), splat_xyz(p.normal), flags);
    c = clamp_crossing(r, b.low, b.high, c);
    ints better = is_nearer(r, best, active, c, number);
    if (!any_lane(better))
        return best;
    COUNT(s, COUNT_FOUND(KIND_POLYGON, together), 1);
    const uint4 range = s->polygon_ranges[index];
    better &= is_inside(r, s->corners + (size_t)range.x * WIDTH, range.y, together);
    return choose_crossing(better, c, number, best);
}
#endif

#if HAS_TRIANGLE
// Whether the entries, triangles that are large for these crossings' distance, are ahead of the ray at all (see is_before).
NOINLINE ints are_ahead(const ray *r, global const real *block, uint k, bool together) {
    return is_before(r->origin, r->direction, load_fields(block, 0, k, together), load_fields(block, 3, k, together),
                     load_fields(block, 6, k, together));
}
#endif

// The nearest hit after the entries k, k + 1, ... have been met, or entry k. Bounds come last, because few are found.
INLINE hit try_entries(const scene *s, const ray *around, ints active, hit best, global const real *block,
                       global const uint *numbers, uint tag, uint k, bool together) {
    const uint kind = tag >> TAG_KIND, flags = (tag >> TAG_FLAGS) & 31;
    COUNT(s, COUNT_TRIED(kind, together), 1);
#if HAS_POLYGON
    if (kind == KIND_POLYGON)
        return try_polygon(s, around, active, best, block, numbers, flags, k, together);
#endif
    const ints number = load_numbers(numbers, k, together);
    const ray r = face_primitive(*around, number);
    crossing c = cross_entries(r, block, kind, flags, k, together);
    c.found &= active & (c.distance > splat(0));
    if (!any_lane(c.found))
        return best;
    COUNT(s, COUNT_FOUND(kind, together), 1);
    const boxes b = load_boxes(block, kind, k, together);
    c = clamp_crossing(r, b.low, b.high, c);
    ints better = is_nearer(r, best, active, c, number);
#if HAS_TRIANGLE
    if (kind == KIND_TRIANGLE && any_lane(better)) {
        const reals size = largest(sub(b.high, b.low));
        const ints close = better & (c.distance < size * R(0x1p-4));
        if (any_lane(close))
            better &= !close | ((c.distance > size * GAMMA(16)) & are_ahead(around, block, k, together));
    }
#endif
    return together ? nearest_lane(best, better, c, number) : choose_crossing(better, c, number, best);
}
