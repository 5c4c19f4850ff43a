// tree.cl - the nearest hit and whether there is any, through the tree or over every block.

// Children that wait: at most WIDTH - 1 for each level of the deepest tree that is built.
#define TREE_STACK 160

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

// Numbers that the lanes held, to be read one by one.
typedef struct {
    real lane[LANES];
} column;

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

// A block against one ray.
INLINE hit try_together(const scene *s, const ray *r, hit best, uint2 link) {
    global const real *block = s->blocks + (size_t)link.x * WIDTH;
    global const uint *numbers = s->block_numbers + (link.y & TAG_NUMBER) * WIDTH;
    for (uint k = 0; k < WIDTH; k += CHUNK) {
#if HAS_POLYGON
        if (link.y >> TAG_KIND == KIND_POLYGON) {
            const boxes b = load_boxes(block, KIND_POLYGON, k, TOGETHER);
            const interval i = intersect_bounds(*r, b.low, b.high);
            uint bits = lane_bits((i.near <= i.far) & (i.far > splat(0)) & (i.near <= best.distance));
            for (bits &= (1u << CHUNK) - 1; bits != 0; bits &= bits - 1)
                best = try_entries(s, r, mask(true), best, block, numbers, link.y, k + lowest_bit(bits), TOGETHER);
            continue;
        }
#endif
        best = try_entries(s, r, mask(true), best, block, numbers, link.y, k, TOGETHER);
    }
    return best;
}

// The nearest hit below `here` for one ray, children side by side. With `any`, the first that comes.
NOINLINE hit traverse_one(const scene *s, const ray *r, hit best, uint2 here, bool any) {
    agenda waiting;
    const sides first = near_sides(r->inverse);
    waiting.height = 0;
    for (;;) {
        if (here.y == LINK_NODE) {
            global const node *n = s->nodes + here.x;
            global const uint2 *links = s->links + here.x * WIDTH;
            errand nearest = {(uint2)(0), INFINITY, 0};
            waiting.floor = waiting.height;
            for (uint k = 0; k < WIDTH; k += CHUNK) {
                const interval i = intersect_rows(r, first, (global const real *)n->rows, k);
                uint bits = lane_bits((i.near <= i.far) & (i.far >= r->least) & (i.near <= best.distance));
                bits &= (1u << CHUNK) - 1;
                const reals near = i.near;
                for (; bits != 0; bits &= bits - 1) {
                    const uint child = lowest_bit(bits);
                    errand e = {links[k + child], REAL_LANE(near, child), 0};
                    if (e.near < nearest.near || nearest.near == R(INFINITY)) {
                        const errand swap = nearest;
                        nearest = e;
                        e = swap;
                    }
                    if (e.near < R(INFINITY))
                        add_errand(&waiting, e);
                }
            }
            if (nearest.near < R(INFINITY)) {
                here = nearest.link;
                continue;
            }
        } else {
            best = try_together(s, r, best, here);
            if (any && INT_LANE(best.primitive, 0) >= 0)
                return best;
        }
        do {
            if (waiting.height == 0)
                return best;
            here = waiting.errands[--waiting.height].link;
        } while (waiting.errands[waiting.height].near > REAL_LANE(best.distance, 0));
    }
}

#if RAYS > 1
// The rays of a packet as one: between which numbers their origins and inverse directions are. An axis along which they
// go both ways tells nothing.
typedef struct {
    real near_origin[3], far_origin[3], least_inverse[3], greatest_inverse[3];
    bool both_ways[3], backwards[3];
    real least; // distance
} beam;

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
    b.least = least_lane(active ? r->least : splat(INFINITY));
    return b;
}

INLINE interval clip_axis(const beam *b, int axis, interval i, reals low, reals high) {
    if (b->both_ways[axis])
        return i;
    const reals enter = (b->backwards[axis] ? high : low) - b->near_origin[axis];
    const reals leave = (b->backwards[axis] ? low : high) - b->far_origin[axis];
    i.near = max(i.near, min(enter * b->least_inverse[axis], enter * b->greatest_inverse[axis]));
    i.far = min(i.far, max(leave * b->least_inverse[axis], leave * b->greatest_inverse[axis]));
    return i;
}

// Which of the boxes side by side a ray of the beam may meet: each operation is monotone, so no box is left out that
// intersect_bounds meets (Reshetov et al. 2005, Multi-Level Ray Tracing Algorithm).
INLINE uint meet_boxes(const beam *b, vectors low, vectors high, real limit) {
    interval i = {splat(-INFINITY), splat(INFINITY)};
    i = clip_axis(b, 0, i, low.x, high.x);
    i = clip_axis(b, 1, i, low.y, high.y);
    i = clip_axis(b, 2, i, low.z, high.z);
    i.far = widen(i.far);
    return lane_bits((i.near <= i.far) & (i.far >= b->least) & (i.near <= limit)) & ((1u << CHUNK) - 1);
}

INLINE hit try_apart(const scene *s, const ray *r, const beam *b, ints active, hit best, uint2 link, real limit) {
    global const real *block = s->blocks + (size_t)link.x * WIDTH;
    global const uint *numbers = s->block_numbers + (link.y & TAG_NUMBER) * WIDTH;
    for (uint chunk = 0; chunk < WIDTH; chunk += CHUNK) {
        const boxes all = load_boxes(block, link.y >> TAG_KIND, chunk, TOGETHER);
        for (uint bits = meet_boxes(b, all.low, all.high, limit); bits != 0; bits &= bits - 1) {
            const uint k = chunk + lowest_bit(bits);
            if (k > 0 && numbers[k] == numbers[k - 1])
                break; // only repetitions follow
            best = try_entries(s, r, active, best, block, numbers, link.y, k, APART);
        }
    }
    return best;
}

// Lane k's ray, in every lane.
ray ray_of_lane(const ray *r, uint k) {
    ray one;
    for (uint i = 0; i < sizeof(ray) / sizeof(reals); i++)
        ((private reals *)&one)[i] = splat(((private const real *)((private const reals *)r + i))[k]);
    return one;
}

// One by one, for each of the lanes.
hit traverse_lanes(const scene *s, const ray *r, uint lanes, hit best, uint2 here, bool any) {
    for (; lanes != 0; lanes &= lanes - 1) {
        const uint k = lowest_bit(lanes);
        const ray one = ray_of_lane(r, k);
        hit h = {splat(REAL_LANE(best.distance, k)), whole(INT_LANE(best.primitive, k)), splat(REAL_LANE(best.u, k)),
                 splat(REAL_LANE(best.v, k))};
        h = traverse_one(s, &one, h, here, any);
        REAL_LANE(best.distance, k) = REAL_LANE(h.distance, 0);
        INT_LANE(best.primitive, k) = INT_LANE(h.primitive, 0);
        REAL_LANE(best.u, k) = REAL_LANE(h.u, 0);
        REAL_LANE(best.v, k) = REAL_LANE(h.v, 0);
    }
    return best;
}

// Fewer rays than this go on alone.
#ifndef FEW
#define FEW 3
#endif

// The nearest hit of many rays, each box and primitive against all of them.
NOINLINE hit traverse_many(const scene *s, const ray *r, ints active, hit best, uint2 here, bool any) {
    agenda waiting;
    const beam b = make_beam(r, active);
    uint lanes = lane_bits(active), looking = lanes;
    real limit = greatest_lane(active ? best.distance : splat(-INFINITY));
    waiting.height = 0;
    for (;;) {
        if (popcount(lanes) < FEW) {
            best = traverse_lanes(s, r, lanes, best, here, any);
        } else if (here.y == LINK_NODE) {
            global const node *n = s->nodes + here.x;
            global const real *rows = (global const real *)n->rows;
            const ints wanted = mask_of_bits(lanes);
            waiting.floor = waiting.height;
            for (uint chunk = 0; chunk < WIDTH; chunk += CHUNK) {
                uint bits = meet_boxes(&b, load_rows(rows, chunk), load_rows(rows + 3 * WIDTH, chunk), limit);
                for (; bits != 0; bits &= bits - 1) {
                    const uint k = chunk + lowest_bit(bits);
                    const interval i = intersect_bounds(
                        *r, make_vectors(splat(rows[k]), splat(rows[WIDTH + k]), splat(rows[2 * WIDTH + k])),
                        make_vectors(splat(rows[3 * WIDTH + k]), splat(rows[4 * WIDTH + k]),
                                     splat(rows[5 * WIDTH + k])));
                    const ints met = wanted & (i.near <= i.far) & (i.far >= r->least) & (i.near <= best.distance);
                    const errand e = {s->links[here.x * WIDTH + k], least_lane(met ? i.near : splat(INFINITY)),
                                      lane_bits(met)};
                    if (e.lanes != 0)
                        add_errand(&waiting, e);
                }
            }
        } else {
            best = try_apart(s, r, &b, mask_of_bits(lanes), best, here, limit);
        }
        if (here.y != LINK_NODE || popcount(lanes) < FEW) {
            if (any)
                looking = lane_bits(active & (best.primitive < 0));
            if (looking == 0)
                return best;
            limit = greatest_lane(mask_of_bits(looking) ? best.distance : splat(-INFINITY));
        }
        do {
            if (waiting.height == 0)
                return best;
            here = waiting.errands[--waiting.height].link;
            lanes = waiting.errands[waiting.height].lanes & looking;
        } while (lanes == 0 || waiting.errands[waiting.height].near > limit);
    }
}
#endif

// Below a node or a block, for the active lanes.
hit traverse_below(const scene *s, const ray *r, ints active, hit best, uint2 here, bool any) {
#if RAYS > 1
    return traverse_many(s, r, active, best, here, any);
#else
    return traverse_one(s, r, best, here, any);
#endif
}

// The nearest hit before `limit`, for the active lanes. With `any`, whichever comes first: only whether there is one counts.
hit traverse(const scene *s, const ray *r, ints active, reals limit, bool any) {
    hit best;
    best.distance = min(limit, splat(FARTHEST));
    best.primitive = whole(-1);
    best.u = best.v = splat(0);
#if HAS_PLANE
    for (uint i = 0; i < s->count.w; i++) {
        const ints number = whole(s->block_numbers[s->count.y * WIDTH + i]);
        const ray one = face_primitive(*r, number);
        const crossing c = intersect_unbounded(s, one, s->primitives[INT_LANE(number, 0)]);
        best = choose_crossing(is_nearer(one, best, active, c, number), c, number, best);
    }
    if (any)
        active &= best.primitive < 0;
#endif
    if (!any_ray(active))
        return best;
#if HAS_TREE
    if (s->count.z > 0)
        best = traverse_below(s, r, active, best, (uint2)(0, LINK_NODE), any);
#else
    for (uint k = 0; k < s->count.y; k++)
        best = traverse_below(s, r, active, best, s->links[k], any);
#endif
    return best;
}

hit closest_hit(const scene *s, const ray *r, ints active) {
    return traverse(s, r, active, splat(INFINITY), false);
}

ints any_hit(const scene *s, const ray *r, ints active, reals limit) {
    return active & (traverse(s, r, active, limit, true).primitive >= 0);
}
