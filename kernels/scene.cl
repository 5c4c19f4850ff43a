// scene.cl - the scene on the device, and which primitive a ray has hit.

typedef struct {
    global const uint4 *primitives; // kind, index among its kind, material, flags
    global const sphere *spheres;
    global const plane *planes;
    global const disc *discs;
    global const box *boxes;
    global const uint4 *triangles; // three indices into vertices and normals
    global const real4 *vertices;
    global const real4 *normals;
    global const polygon *polygons;
    global const uint4 *polygon_ranges; // first row, number of corners
    global const real *corners;         // rows of WIDTH
    global const cone *cones;
    global const instance *instances;
    global const uint4
        *instance_roots;      // where its group is: a node, or without a tree links from the first to the last
    global const real *nodes; // NODE_ROWS rows of WIDTH each
    global const uint2 *links;
    global const real *blocks;
    global const uint *block_numbers; // WIDTH primitive numbers for each block, then the planes' numbers
    global const material *materials;
    global const light *lights;
    uint4 count; // lights, blocks, nodes, planes
#if COUNTING
    uint *counts;
#endif
#if MARGIN
  private
    real *margin; // the least so far
#endif
#if RECORD
    notebook *notes; // the last member: entry points that note nothing leave it out
#endif
} scene;

// The primitives hit: their material and flags. `instance`: the index of the one that they are in, or -1.
typedef struct {
    ints kind, index, material, flags;
#if HAS_INSTANCE
    ints instance;
#endif
} identity;

// In one lane: the primitive, or that inside of it, and the instance.
void identify_lane(const scene *s, identity *id, int lane, integer number, integer inside) {
    uint4 p = s->primitives[number];
#if HAS_INSTANCE
    INT_LANE(id->instance, lane) = p.x == KIND_INSTANCE ? (integer)p.y : -1;
    if (p.x == KIND_INSTANCE) {
        const uint material = p.z;
        p = s->primitives[inside];
        p.z = material == OWN_MATERIAL ? p.z : material;
    }
#endif
    INT_LANE(id->kind, lane) = p.x;
    INT_LANE(id->index, lane) = p.y;
    INT_LANE(id->material, lane) = p.z;
    INT_LANE(id->flags, lane) = p.w;
}

// The same for all lanes.
identity identify_one(const scene *s, integer number, integer inside) {
    identity id;
    identify_lane(s, &id, 0, number, inside);
    id.kind = whole(INT_LANE(id.kind, 0));
    id.index = whole(INT_LANE(id.index, 0));
    id.material = whole(INT_LANE(id.material, 0));
    id.flags = whole(INT_LANE(id.flags, 0));
#if HAS_INSTANCE
    id.instance = whole(INT_LANE(id.instance, 0));
#endif
    return id;
}

// Lanes that are not active get what another has.
identity identify(const scene *s, ints active, const hit *h) {
#if HAS_INSTANCE
    const ints inside = h->inside;
#else
    const ints inside = whole(0);
#endif
#if RAYS == 1
    const bool found = INT_LANE(active, 0);
    return identify_one(s, found ? INT_LANE(h->primitive, 0) : 0, found ? INT_LANE(inside, 0) : 0);
#else
    const uint bits = lane_bits(active), some = bits ? lowest_bit(bits) : 0;
    const integer number = bits ? INT_LANE(h->primitive, some) : 0, deep = INT_LANE(inside, some);
    const ints differs = active & ((h->primitive != whole(number)) | (inside != whole(deep)));
    if (!any_lane(differs))
        return identify_one(s, number, deep);
    identity id;
    for (int lane = 0; lane < LANES; lane++)
        identify_lane(s, &id, lane, INT_LANE(differs, lane) ? INT_LANE(h->primitive, lane) : number,
                      INT_LANE(differs, lane) ? INT_LANE(inside, lane) : deep);
    return id;
#endif
}
