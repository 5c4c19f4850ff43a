// traverse.cl - the nearest hit and whether there is any, through the tree or over every block.
//
// A walk stops where it comes to an instance: whoever walks goes inside by a walk of its own, and then on.
#if HAS_INSTANCE
#define WALK NOINLINE
#else
#define WALK INLINE
#endif

// A link to nowhere: the walk is over.
#define IS_OVER(link) ((link).y == LINK_NODE)

bool is_instance(uint2 link) {
    return HAS_INSTANCE && link.y >> TAG_KIND == KIND_INSTANCE && link.y != LINK_NODE;
}

integer instance_number(const scene *s, uint2 link) {
    return s->block_numbers[(link.y & TAG_NUMBER) * WIDTH];
}

// Where a tree begins: its root, or without a tree the k-th link.
uint2 first_link(const scene *s, uint k) {
    return HAS_TREE ? (uint2)(k, LINK_NODE) : s->links[k];
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
            uint bits =
                lane_bits((i.near <= i.far) & (i.far >= nearest_far(r)) & (i.near <= farthest_near(r, best.distance)));
            for (bits &= (1u << CHUNK) - 1; bits != 0; bits &= bits - 1) {
                const uint entry = k + lowest_bit(bits);
                if (entry > 0 && numbers[entry] == numbers[entry - 1])
                    break; // only repetitions follow
                best = try_entries(s, r, mask(true), best, block, numbers, link.y, entry, TOGETHER);
            }
            continue;
        }
#endif
        best = try_entries(s, r, mask(true), best, block, numbers, link.y, k, TOGETHER);
    }
    return best;
}

// One ray's way from `at` on, children side by side, until nothing waits or there is an instance, where it leaves `at`.
// With `any`, it ends at the first hit.
WALK hit walk_one(const scene *s, const ray *r, hit best, agenda *waiting, uint2 *at, bool any) {
    const sides first = near_sides(r->inverse);
    for (uint2 here = *at;;) {
        if (here.y == LINK_NODE) {
            global const real *rows = s->nodes + (size_t)here.x * NODE_ROWS * WIDTH;
            global const uint2 *links = s->links + (size_t)here.x * WIDTH;
            errand nearest = {(uint2)(0), INFINITY, 0};
            COUNT(s, COUNT_NODES, 1);
            waiting->floor = waiting->height;
            for (uint k = 0; k < WIDTH; k += CHUNK) {
                const interval i = intersect_rows(r, first, rows, k);
                uint bits = lane_bits((i.near <= i.far) & (i.far >= nearest_far(r)) &
                                      (i.near <= farthest_near(r, best.distance)));
                bits &= (1u << CHUNK) - 1;
                COUNT(s, COUNT_CHILDREN, popcount(bits));
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
                        add_errand(waiting, e);
                }
            }
            if (nearest.near < R(INFINITY)) {
                here = nearest.link;
                continue;
            }
        } else if (is_instance(here)) {
            *at = here;
            return best;
        } else {
            best = try_together(s, r, best, here);
            if (any && INT_LANE(best.primitive, 0) >= 0)
                waiting->height = 0;
        }
        const reals limit = farthest_near(r, best.distance);
        errand next;
        if (!take_errand(waiting, REAL_LANE(limit, 0), &next)) {
            at->y = LINK_NODE;
            return best;
        }
        here = next.link;
    }
}

#if HAS_INSTANCE
hit visit_one(const scene *s, const ray *r, hit best, integer number, bool any) {
    visit v = enter_instance(s, r, mask(true), best, number);
    if (!any_lane(v.active))
        return best;
    const uint4 roots = s->instance_roots[s->primitives[number].y];
    for (uint k = roots.x; k < roots.y; k++) {
        agenda waiting;
        uint2 at = first_link(s, k);
        waiting.height = 0;
        v.best = walk_one(s, &v.ray, v.best, &waiting, &at, any);
    }
    return leave_instance(&v, best, number);
}
#endif

// The nearest hit below `here` for one ray. With `any`, the first that comes.
NOINLINE hit traverse_one(const scene *s, const ray *r, hit best, uint2 here, bool any) {
    COUNT(s, COUNT_LONE, 1);
    agenda waiting;
    waiting.height = 0;
    best = walk_one(s, r, best, &waiting, &here, any);
#if HAS_INSTANCE
    while (!IS_OVER(here)) {
        errand next;
        best = visit_one(s, r, best, instance_number(s, here), any);
        if (any && INT_LANE(best.primitive, 0) >= 0)
            return best;
        if (!take_errand(&waiting, REAL_LANE(best.distance, 0), &next))
            return best;
        here = next.link;
        best = walk_one(s, r, best, &waiting, &here, any);
    }
#endif
    return best;
}

#if RAYS > 1 || FANS
INLINE hit try_apart(const scene *s, const ray *r, const beam *b, ints active, hit best, uint2 link, real limit) {
    global const real *block = s->blocks + (size_t)link.x * WIDTH;
    global const uint *numbers = s->block_numbers + (link.y & TAG_NUMBER) * WIDTH;
    COUNT(s, COUNT_BLOCKS(link.y >> TAG_KIND), 1);
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
        hit h = no_hit(splat(REAL_LANE(best.distance, k)));
        h.primitive = whole(INT_LANE(best.primitive, k));
        h.u = splat(REAL_LANE(best.u, k));
        h.v = splat(REAL_LANE(best.v, k));
#if HAS_INSTANCE
        h.inside = whole(INT_LANE(best.inside, k));
        h = traverse_one(s, &one, h, here, any);
        INT_LANE(best.inside, k) = INT_LANE(h.inside, 0);
#else
        h = traverse_one(s, &one, h, here, any);
#endif
        REAL_LANE(best.distance, k) = REAL_LANE(h.distance, 0);
        INT_LANE(best.primitive, k) = INT_LANE(h.primitive, 0);
        REAL_LANE(best.u, k) = REAL_LANE(h.u, 0);
        REAL_LANE(best.v, k) = REAL_LANE(h.v, 0);
    }
    return best;
}

// So few children go on without asking every ray: most often all of a beam's rays meet them.
#ifndef TIGHT
#define TIGHT 2
#endif

// Fewer rays than this go on alone.
#ifndef FEW
#define FEW 3
#endif

// Nothing nearer than any active ray's hit begins beyond it.
real common_limit(const ray *r, ints active, const hit *best) {
    return greatest_lane(active ? farthest_near(r, best->distance) : splat(-INFINITY));
}

// An errand to the k-th child, only for those rays that meet its box.
INLINE errand ask_rays(const ray *r, ints wanted, const hit *best, errand e, global const real *rows, uint k) {
    const interval i = intersect_bounds(
        *r, make_vectors(splat(rows[k]), splat(rows[WIDTH + k]), splat(rows[2 * WIDTH + k])),
        make_vectors(splat(rows[3 * WIDTH + k]), splat(rows[4 * WIDTH + k]), splat(rows[5 * WIDTH + k])));
    const ints met =
        wanted & (i.near <= i.far) & (i.far >= nearest_far(r)) & (i.near <= farthest_near(r, best->distance));
    e.near = least_lane(met ? i.near : splat(INFINITY));
    e.lanes = lane_bits(met);
    return e;
}

// Many rays' way from `at` on, each box and primitive against all of them, as walk_one.
WALK hit walk_many(const scene *s, const ray *r, ints active, hit best, agenda *waiting, errand *at, bool any) {
    COUNT(s, COUNT_BEAMS, 1);
    const beam b = make_beam(r, active);
    uint2 here = at->link;
    uint lanes = at->lanes, looking = lane_bits(active);
    real limit = common_limit(r, active, &best);
    reals before = best.distance;
    for (;;) {
        if (is_instance(here)) {
            at->link = here;
            at->lanes = lanes;
            return best;
        }
        if (popcount(lanes) < FEW) {
            best = traverse_lanes(s, r, lanes, best, here, any);
        } else if (here.y == LINK_NODE) {
            global const real *rows = s->nodes + (size_t)here.x * NODE_ROWS * WIDTH;
            const ints wanted = mask_of_bits(lanes);
            COUNT(s, COUNT_BOXES, 1);
            waiting->floor = waiting->height;
            for (uint chunk = 0; chunk < WIDTH; chunk += CHUNK) {
                const interval beams = intersect_beam(&b, load_rows(rows, chunk), load_rows(rows + 3 * WIDTH, chunk));
                uint bits = open_boxes(&b, beams, limit);
                const bool tight = popcount(bits) <= TIGHT;
                COUNT(s, COUNT_TESTS, tight ? 0 : popcount(bits));
                for (; bits != 0; bits &= bits - 1) {
                    const uint k = lowest_bit(bits);
                    const reals near = beams.near;
                    const errand all = {s->links[(size_t)here.x * WIDTH + chunk + k], REAL_LANE(near, k), lanes};
                    const errand e = tight ? all : ask_rays(r, wanted, &best, all, rows, chunk + k);
                    COUNT(s, COUNT_ERRANDS, e.lanes != 0);
                    if (e.lanes != 0)
                        add_errand(waiting, e);
                }
            }
        } else {
            best = try_apart(s, r, &b, mask_of_bits(lanes), best, here, limit);
        }
        if (any_lane(best.distance < before)) {
            before = best.distance;
            if (any)
                looking = lane_bits(active & (best.primitive < 0));
            if (looking == 0)
                waiting->height = 0;
            limit = common_limit(r, mask_of_bits(looking), &best);
        }
        do {
            errand next;
            if (!take_errand(waiting, limit, &next)) {
                at->link.y = LINK_NODE;
                return best;
            }
            here = next.link;
            lanes = next.lanes & looking;
        } while (lanes == 0);
    }
}

#if HAS_INSTANCE
hit visit_many(const scene *s, const ray *r, ints active, hit best, integer number, bool any) {
    visit v = enter_instance(s, r, active, best, number);
    if (!any_lane(v.active))
        return best;
    const uint4 roots = s->instance_roots[s->primitives[number].y];
    for (uint k = roots.x; k < roots.y; k++) {
        agenda waiting;
        errand at = {first_link(s, k), R(0), lane_bits(v.active)};
        waiting.height = 0;
        v.best = walk_many(s, &v.ray, v.active, v.best, &waiting, &at, any);
    }
    return leave_instance(&v, best, number);
}
#endif

// The nearest hit below `here` for many rays.
NOINLINE hit traverse_many(const scene *s, const ray *r, ints active, hit best, uint2 here, bool any) {
    agenda waiting;
    errand at = {here, R(0), lane_bits(active)};
    waiting.height = 0;
    best = walk_many(s, r, active, best, &waiting, &at, any);
#if HAS_INSTANCE
    while (!IS_OVER(at.link)) {
        best = visit_many(s, r, mask_of_bits(at.lanes), best, instance_number(s, at.link), any);
        if (any)
            active &= best.primitive < 0;
        const uint looking = lane_bits(active);
        const real limit = common_limit(r, active, &best);
        do {
            if (looking == 0 || !take_errand(&waiting, limit, &at))
                return best;
            at.lanes &= looking;
        } while (at.lanes == 0);
        best = walk_many(s, r, active, best, &waiting, &at, any);
    }
#endif
    return best;
}
#endif

// Below a node or a block, for the active lanes.
hit traverse_below(const scene *s, const ray *r, ints active, hit best, uint2 here, bool any) {
#if FANS
    if (any) {
        const uint lanes = lane_bits(active);
        return popcount(lanes) < FEW ? traverse_lanes(s, r, lanes, best, here, any)
                                     : traverse_many(s, r, active, best, here, any);
    }
#endif
#if RAYS > 1
    return traverse_many(s, r, active, best, here, any);
#else
    return traverse_one(s, r, best, here, any);
#endif
}

// The nearest hit before `limit`, for the active lanes. With `any`, whichever comes first: only whether there is one counts.
hit traverse(const scene *s, const ray *r, ints active, reals limit, bool any) {
    hit best = no_hit(min(limit, splat(FARTHEST)));
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
    if (!any_lane(active))
        return best;
#if HAS_TREE
    if (s->count.z > 0) {
        const hit before = best;
        best = traverse_below(s, r, active, before, first_link(s, 0), any);
        if (TRAVERSALS > 1)
            best.primitive = traverse_below(s, r, active, before, first_link(s, 0), any).primitive;
    }
#else
    for (uint k = 0; k < s->count.y; k++)
        best = traverse_below(s, r, active, best, first_link(s, k), any);
#endif
    return best;
}

hit closest_hit(const scene *s, const ray *r, ints active) {
    return traverse(s, r, active, splat(INFINITY), false);
}

ints any_hit(const scene *s, const ray *r, ints active, reals limit) {
    return active & (traverse(s, r, active, limit, true).primitive >= 0);
}
