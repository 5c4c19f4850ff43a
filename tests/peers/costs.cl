// costs.cl - the steps of a traversal, each alone: limit.py appends this to the kernels. All data stay in the first cache,
// no step waits for another, and a sum keeps the compiler from leaving anything out.
#define MANY 16   // different rays, nodes and blocks
#define INNER 512 // steps for each ray

typedef struct {
    scene s;
    ray r;
    sides first;
#if RAYS > 1
    beam b;
#endif
} given;

ray load_ray(global const real *rays, uint k) {
    reals c[6];
    for (uint i = 0; i < 6; i++)
        c[i] = JOIN(vload, LANES)(0, rays + (k * 6 + i) * 16);
    return make_ray(make_vectors(c[0], c[1], c[2]), make_vectors(c[3], c[4], c[5]));
}

INLINE void start(given *g, ray r) {
    g->r = r;
    g->first = near_sides(r.inverse);
#if RAYS > 1
    g->b = make_beam(&r, mask(true));
#endif
}

uint sum_of_hit(hit h) {
    return (uint)INT_LANE(h.primitive, 0) + as_uint((float)REAL_LANE(h.distance, 0));
}

INLINE uint step_node(const given *g, uint k) {
    const interval i = intersect_rows(&g->r, g->first, g->s.nodes + k * NODE_ROWS * WIDTH, 0);
    return lane_bits((i.near <= i.far) & (i.far >= nearest_far(&g->r)) &
                     (i.near <= farthest_near(&g->r, splat(FARTHEST)))) &
           ((1u << CHUNK) - 1);
}

// Three children that are met, as walk_one has them.
INLINE uint step_children(const given *g, uint k) {
    agenda waiting;
    waiting.floor = waiting.height = 0;
    errand nearest = {(uint2)(0), INFINITY, 0};
    const reals near = load_row(g->s.nodes + k * NODE_ROWS * WIDTH, 0);
    for (uint bits = g->s.block_numbers[k]; bits != 0; bits &= bits - 1) {
        const uint child = lowest_bit(bits);
        errand e = {g->s.links[child], REAL_LANE(near, child), 0};
        if (e.near < nearest.near || nearest.near == R(INFINITY)) {
            const errand swap = nearest;
            nearest = e;
            e = swap;
        }
        if (e.near < R(INFINITY))
            add_errand(&waiting, e);
    }
    uint sum = nearest.link.x;
    for (errand e; take_errand(&waiting, R(FARTHEST), &e);)
        sum += e.link.x;
    return sum;
}

INLINE uint try_block(const given *g, uint k, bool together) {
    const uint2 link = g->s.links[k];
    return sum_of_hit(try_entries(&g->s, &g->r, mask(true), no_hit(splat(FARTHEST)), g->s.blocks + link.x * WIDTH,
                                  g->s.block_numbers + MANY, link.y, 0, together));
}

INLINE uint step_block(const given *g, uint k) {
    return try_block(g, k, TOGETHER);
}

// A way that ends at its first block.
INLINE uint step_way(const given *g, uint k) {
#if RAYS == 1
    return sum_of_hit(traverse_one(&g->s, &g->r, no_hit(splat(FARTHEST)), g->s.links[k], false));
#else
    return sum_of_hit(traverse_lanes(&g->s, &g->r, 1u << k, no_hit(splat(FARTHEST)), g->s.links[k], false));
#endif
}

#if RAYS > 1
INLINE uint step_beam_way(const given *g, uint k) {
    return sum_of_hit(traverse_many(&g->s, &g->r, mask(true), no_hit(splat(FARTHEST)), g->s.links[k], false));
}

INLINE uint step_boxes(const given *g, uint k) {
    global const real *rows = g->s.nodes + k * NODE_ROWS * WIDTH;
    const interval i = intersect_beam(&g->b, load_rows(rows, 0), load_rows(rows + 3 * WIDTH, 0));
    return open_boxes(&g->b, i, R(FARTHEST));
}

INLINE uint step_test(const given *g, uint k) {
    const hit none = no_hit(splat(FARTHEST));
    const errand all = {g->s.links[k], R(0), 0xffff};
    const errand e = ask_rays(&g->r, mask(true), &none, all, g->s.nodes + k * NODE_ROWS * WIDTH, 0);
    return e.lanes + as_uint((float)e.near);
}

// Three children that wait.
INLINE uint step_errands(const given *g, uint k) {
    agenda waiting;
    waiting.floor = waiting.height = 0;
    const reals near = load_row(g->s.nodes + k * NODE_ROWS * WIDTH, 0);
    for (uint bits = g->s.block_numbers[k]; bits != 0; bits &= bits - 1) {
        const uint child = lowest_bit(bits);
        const errand e = {g->s.links[child], REAL_LANE(near, child), bits};
        add_errand(&waiting, e);
    }
    uint sum = 0;
    for (errand e; take_errand(&waiting, R(FARTHEST), &e);)
        sum += e.link.x + e.lanes;
    return sum;
}

INLINE uint step_beam_block(const given *g, uint k) {
    const uint2 link = g->s.links[k];
    const boxes all = load_boxes(g->s.blocks + link.x * WIDTH, link.y >> TAG_KIND, 0, TOGETHER);
    return meet_boxes(&g->b, all.low, all.high, R(FARTHEST));
}

INLINE uint step_entry(const given *g, uint k) {
    return try_block(g, k, APART);
}
#endif

#define MEASURE(step)                                                                                                  \
    kernel __attribute__((vec_type_hint(reals))) void measure_##step(                                                  \
        global const real *nodes, global const uint2 *links, global const real *blocks, global const uint *numbers,    \
        global const uint4 *primitives, global const polygon *polygons, global const uint4 *polygon_ranges,            \
        global const real *corners, global const real *rays, const uint rounds, global uint *out) {                    \
        given g;                                                                                                       \
        g.s.nodes = nodes;                                                                                             \
        g.s.links = links;                                                                                             \
        g.s.blocks = blocks;                                                                                           \
        g.s.block_numbers = numbers;                                                                                   \
        g.s.primitives = primitives;                                                                                   \
        g.s.polygons = polygons;                                                                                       \
        g.s.polygon_ranges = polygon_ranges;                                                                           \
        g.s.corners = corners;                                                                                         \
        uint sum = 0;                                                                                                  \
        for (uint i = 0; i < rounds; i++) {                                                                            \
            start(&g, load_ray(rays, i % MANY));                                                                       \
            for (uint k = 0; k < INNER; k++)                                                                           \
                sum += step_##step(&g, k % MANY);                                                                      \
        }                                                                                                              \
        out[0] = sum;                                                                                                  \
    }

MEASURE(node)
MEASURE(children)
MEASURE(block)
MEASURE(way)
#if RAYS > 1
MEASURE(boxes)
MEASURE(test)
MEASURE(errands)
MEASURE(beam_block)
MEASURE(entry)
MEASURE(beam_way)
#endif
