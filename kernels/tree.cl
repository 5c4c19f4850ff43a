// tree.cl - what a ray, or many as one beam, meets of a node's children.

// Children that wait: at most WIDTH - 1 for each level of the deepest tree that is built.
#define TREE_STACK 320

// A child or several that wait, and the distance before which there is nothing in them.
typedef struct {
    uint2 link;
    real near;
    uint lanes; // that want to see it
} errand;

typedef struct {
    errand errands[TREE_STACK];
    uint height, floor;
} agenda;

// Puts an errand in its place above the floor, the nearest on top.
INLINE void add_errand(agenda *a, errand e) {
    uint at = a->height++;
    for (; at > a->floor && a->errands[at - 1].near < e.near; at--)
        a->errands[at] = a->errands[at - 1];
    a->errands[at] = e;
}

// The next errand that begins before the limit, if there is one.
INLINE bool take_errand(agenda *a, real limit, errand *e) {
    do {
        if (a->height == 0)
            return false;
        *e = a->errands[--a->height];
    } while (e->near > limit);
    return true;
}

// One ray, in every lane. Which rows of a node hold the planes that it meets first.
typedef struct {
    uint x, y, z;
} sides;

sides near_sides(vectors inverse) {
    const sides n = {REAL_LANE(inverse.x, 0) < R(0) ? 3 : 0, REAL_LANE(inverse.y, 0) < R(0) ? 4 : 1,
                     REAL_LANE(inverse.z, 0) < R(0) ? 5 : 2};
    return n;
}

// The ray's interval in the boxes k, k + 1, ... of six rows: that of intersect_bounds.
INLINE interval intersect_rows(const ray *r, sides n, global const real *rows, uint k) {
    interval i;
    i.near = max(max((load_row(rows + n.x * WIDTH, k) - r->origin.x) * r->inverse.x,
                     (load_row(rows + n.y * WIDTH, k) - r->origin.y) * r->inverse.y),
                 (load_row(rows + n.z * WIDTH, k) - r->origin.z) * r->inverse.z);
    i.far = widen(min(min((load_row(rows + (3 - n.x) * WIDTH, k) - r->origin.x) * r->inverse.x,
                          (load_row(rows + (5 - n.y) * WIDTH, k) - r->origin.y) * r->inverse.y),
                      (load_row(rows + (7 - n.z) * WIDTH, k) - r->origin.z) * r->inverse.z));
    return i;
}

// Many rays as one: between which numbers their origins and inverse directions are. An axis along which they go both ways
// tells nothing.
typedef struct {
    real near_origin[3], far_origin[3], least_inverse[3], greatest_inverse[3];
    bool both_ways[3], backwards[3];
    real least; // distance
} beam;

#if RAYS > 1 || FANS
void set_beam_axis(beam *b, int axis, reals origin, reals inverse, ints active) {
    const real low = least_lane(active ? origin : splat(INFINITY)),
               high = greatest_lane(active ? origin : splat(-INFINITY));
    const real least = least_lane(active ? inverse : splat(INFINITY)),
               greatest = greatest_lane(active ? inverse : splat(-INFINITY));
    b->backwards[axis] = greatest < R(0);
    b->both_ways[axis] = least < R(0) && greatest > R(0);
    b->near_origin[axis] = greatest < R(0) ? low : high;
    b->far_origin[axis] = greatest < R(0) ? high : low;
    b->least_inverse[axis] = least;
    b->greatest_inverse[axis] = greatest;
}

beam make_beam(const ray *r, ints active) {
    beam b;
    set_beam_axis(&b, 0, r->origin.x, r->inverse.x, active);
    set_beam_axis(&b, 1, r->origin.y, r->inverse.y, active);
    set_beam_axis(&b, 2, r->origin.z, r->inverse.z, active);
    b.least = least_lane(active ? nearest_far(r) : splat(INFINITY));
    return b;
}
#endif

INLINE interval clip_axis(const beam *b, int axis, interval i, reals low, reals high) {
    if (b->both_ways[axis])
        return i;
    const reals enter = (b->backwards[axis] ? high : low) - b->near_origin[axis];
    const reals leave = (b->backwards[axis] ? low : high) - b->far_origin[axis];
    i.near = max(i.near, min(enter * b->least_inverse[axis], enter * b->greatest_inverse[axis]));
    i.far = min(i.far, max(leave * b->least_inverse[axis], leave * b->greatest_inverse[axis]));
    return i;
}

// The beam's interval in each of the boxes side by side: each operation is monotone, so it holds that of every ray
// (Reshetov et al. 2005, Multi-Level Ray Tracing Algorithm).
INLINE interval intersect_beam(const beam *b, vectors low, vectors high) {
    interval i = {splat(-INFINITY), splat(INFINITY)};
    i = clip_axis(b, 0, i, low.x, high.x);
    i = clip_axis(b, 1, i, low.y, high.y);
    i = clip_axis(b, 2, i, low.z, high.z);
    i.far = widen(i.far);
    return i;
}

// In which of the boxes there may be something for a ray of the beam.
uint open_boxes(const beam *b, interval i, real limit) {
    return lane_bits((i.near <= i.far) & (i.far >= b->least) & (i.near <= limit)) & ((1u << CHUNK) - 1);
}

// Which of the boxes side by side a ray of the beam may meet: none is left out that intersect_bounds meets.
INLINE uint meet_boxes(const beam *b, vectors low, vectors high, real limit) {
    return open_boxes(b, intersect_beam(b, low, high), limit);
}
