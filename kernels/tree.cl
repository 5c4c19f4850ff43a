// tree.cl - the nearest hit and whether there is any, through the tree or over every primitive.

// Children that wait: at most WIDTH - 1 for each level of the deepest tree that is built.
#define TREE_STACK 160

// The nearest distance at which the ray, or any of the rays, enters child k's box; INFINITY where none does.
typedef struct {
    real near[WIDTH] __attribute__((aligned(64)));
} entries;

entries enter_children(global const node *n, const ray *around, ints active, reals limit) {
    const ray r = *around;
    entries e;
#if RAYS == 1
    for (uint k = 0; k < WIDTH; k += LANES) {
        const vectors low = make_vectors(*(global const reals *)(n->low[0] + k), *(global const reals *)(n->low[1] + k),
                                         *(global const reals *)(n->low[2] + k));
        const vectors high =
            make_vectors(*(global const reals *)(n->high[0] + k), *(global const reals *)(n->high[1] + k),
                         *(global const reals *)(n->high[2] + k));
        const interval i = intersect_bounds(r, low, high);
        const ints met = (i.near <= i.far) & (i.far >= r.least) & (i.near <= limit);
        *(private reals *)(e.near + k) = met ? i.near : splat(INFINITY);
    }
#else
    for (uint k = 0; k < WIDTH; k++) {
        const vectors low = make_vectors(splat(n->low[0][k]), splat(n->low[1][k]), splat(n->low[2][k]));
        const vectors high = make_vectors(splat(n->high[0][k]), splat(n->high[1][k]), splat(n->high[2][k]));
        const interval i = intersect_bounds(r, low, high);
        const ints met = active & (i.near <= i.far) & (i.far >= r.least) & (i.near <= limit);
        e.near[k] = any_lane(met) ? least_lane(met ? i.near : splat(INFINITY)) : R(INFINITY);
    }
#endif
    return e;
}

// Lanes that still look: all for the nearest hit, those without one where any will do.
ints still_looking(ints active, hit best, bool any) {
    return any ? active & (best.primitive < 0) : active;
}

// The nearest hit before `limit`, for the active lanes. With `any`, whichever comes first: only whether there is one counts.
hit traverse(const scene *s, const ray *r, ints active, reals limit, bool any) {
    hit best;
    best.distance = limit;
    best.primitive = whole(-1);
    best.u = best.v = splat(0);
#if HAS_PLANE
    for (uint i = 0; i < s->count.w; i++) {
        const ints number = whole(s->block_numbers[s->count.y * WIDTH + i]);
        const crossing c = intersect_unbounded(s, *r, s->primitives[INT_LANE(number, 0)]);
        best = nearer(face_primitive(*r, number), best, active, c, number);
    }
#endif
#if HAS_TREE
    uint2 waiting[TREE_STACK];
    real distances[TREE_STACK];
    uint height = 0;
    uint2 here = (uint2)(0, LINK_NODE);
    if (s->count.z == 0)
        return best;
    for (;;) {
        if (here.y == LINK_NODE) {
            const entries e = enter_children(s->nodes + here.x, r, active, best.distance);
            global const uint2 *links = s->links + here.x * WIDTH;
            const uint floor = height;
            for (uint k = 0; k < WIDTH; k++) {
                const real near = e.near[k];
                if (near == R(INFINITY))
                    continue;
                uint at = height++; // kept in order, the nearest on top
                for (; at > floor && distances[at - 1] < near; at--) {
                    distances[at] = distances[at - 1];
                    waiting[at] = waiting[at - 1];
                }
                distances[at] = near;
                waiting[at] = links[k];
            }
        } else {
            best = try_block(s, r, active, best, here.x, here.y);
            active = still_looking(active, best, any);
            if (any && !any_ray(active))
                return best;
        }
        do {
            if (height == 0)
                return best;
            here = waiting[--height];
        } while (distances[height] > greatest_ray(best.distance));
    }
#else
    for (uint k = 0; k < s->count.y; k++)
        best = try_block(s, r, active, best, s->links[k].x, s->links[k].y);
    return best;
#endif
}

hit closest_hit(const scene *s, const ray *r, ints active) {
    return traverse(s, r, active, splat(INFINITY), false);
}

ints any_hit(const scene *s, const ray *r, ints active, reals limit) {
    return active & (traverse(s, r, active, limit, true).primitive >= 0);
}
