/* tree.c - the tree over the bounded primitives: its shape by Embree's builder, its boxes ours. */
#include "clock.h"
#include "packed.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_IN_LEAF = 4 };

typedef struct branch {
    size_t count; /* primitives, 0 for an inner node */
    union {
        struct branch *children[2];
        uint32_t numbers[MOST_IN_LEAF];
    };
} branch;

static bounds empty_bounds(void) {
    return (bounds){{INFINITY, INFINITY, INFINITY, 0}, {-INFINITY, -INFINITY, -INFINITY, 0}};
}

static bounds join(bounds a, bounds b) {
    return (bounds){{fmin(a.low.x, b.low.x), fmin(a.low.y, b.low.y), fmin(a.low.z, b.low.z), 0},
                    {fmax(a.high.x, b.high.x), fmax(a.high.y, b.high.y), fmax(a.high.z, b.high.z), 0}};
}

bounds primitive_bounds(const packed *p, size_t number) {
    uint4 primitive = ((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[number];
    uint32_t index = primitive.y;
    switch (primitive.x) {
    case KIND_SPHERE:
        return ((const sphere *)p->arrays[ARRAY_SPHERES].data)[index].bounds;
    case KIND_DISC:
        return ((const disc *)p->arrays[ARRAY_DISCS].data)[index].bounds;
    case KIND_BOX:
        return ((const box *)p->arrays[ARRAY_BOXES].data)[index].bounds;
    case KIND_POLYGON:
        return ((const polygon *)p->arrays[ARRAY_POLYGONS].data)[index].bounds;
    case KIND_CONE:
        return ((const cone *)p->arrays[ARRAY_CONES].data)[index].bounds;
    case KIND_TRIANGLE: {
        uint4 t = ((const uint4 *)p->arrays[ARRAY_TRIANGLES].data)[index];
        const real4 *v = p->arrays[ARRAY_VERTICES].data;
        return join(join((bounds){v[t.x], v[t.x]}, (bounds){v[t.y], v[t.y]}), (bounds){v[t.z], v[t.z]});
    }
    default:
        return empty_bounds();
    }
}

static void *create_node(RTCThreadLocalAllocator allocator, unsigned int count, void *user) {
    (void)count, (void)user;
    branch *b = rtcThreadLocalAlloc(allocator, sizeof *b, 16);
    if (b)
        b->count = 0;
    return b;
}

static void set_children(void *node, void **children, unsigned int count, void *user) {
    (void)user;
    for (unsigned int i = 0; i < count; i++)
        ((branch *)node)->children[i] = children[i];
}

/* The tree keeps no boxes of Embree's: they are float, and ours are those that the device computes with. */
static void set_bounds(void *node, const struct RTCBounds **boxes, unsigned int count, void *user) {
    (void)node, (void)boxes, (void)count, (void)user;
}

static void *create_leaf(RTCThreadLocalAllocator allocator, const struct RTCBuildPrimitive *primitives, size_t count,
                         void *user) {
    (void)user;
    branch *b = count <= MOST_IN_LEAF ? rtcThreadLocalAlloc(allocator, sizeof *b, 16) : NULL;
    if (!b)
        return NULL;
    b->count = count;
    for (size_t i = 0; i < count; i++)
        b->numbers[i] = primitives[i].primID;
    return b;
}

static float lower(double x) {
    return nextafterf((float)x, -INFINITY);
}

static float upper(double x) {
    return nextafterf((float)x, INFINITY);
}

static struct RTCBuildPrimitive *build_primitives(const packed *p, const uint32_t *order, feeler_error *error) {
    struct RTCBuildPrimitive *out = aligned_alloc(32, (p->bounded ? p->bounded : 1) * sizeof *out);
    if (!out) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a tree over %zu primitives", p->bounded);
        return NULL;
    }
    for (size_t i = 0; i < p->bounded; i++) {
        bounds b = primitive_bounds(p, order[i]);
        out[i] = (struct RTCBuildPrimitive){
            .lower_x = lower(b.low.x),
            .lower_y = lower(b.low.y),
            .lower_z = lower(b.low.z),
            .upper_x = upper(b.high.x),
            .upper_y = upper(b.high.y),
            .upper_z = upper(b.high.z),
            .geomID = 0,
            .primID = order[i],
        };
    }
    return out;
}

/* Writes the branch and what is below it in depth-first order; returns its box. */
static bounds flatten(packed *p, const branch *b, uint32_t *next_entry) {
    size_t index = p->arrays[ARRAY_NODES].count++;
    node *nodes = p->arrays[ARRAY_NODES].data;
    uint4 *links = p->arrays[ARRAY_LINKS].data;
    uint32_t *order = p->arrays[ARRAY_ORDER].data;
    bounds box = empty_bounds();
    links[index] = (uint4){0, *next_entry, (uint32_t)b->count, 0};
    for (size_t i = 0; i < b->count; i++) {
        order[(*next_entry)++] = b->numbers[i];
        box = join(box, primitive_bounds(p, b->numbers[i]));
    }
    if (b->count == 0)
        for (int i = 0; i < 2; i++)
            box = join(box, flatten(p, b->children[i], next_entry));
    nodes[index].bounds = box;
    links[index].x = (uint32_t)p->arrays[ARRAY_NODES].count;
    return box;
}

/* Room for all nodes first, so that flatten cannot fail: a binary tree has fewer inner nodes than leaves. */
static int reserve(array *a, size_t count, feeler_error *error) {
    if (!array_add(a, count, error))
        return -1;
    a->count = 0;
    return 0;
}

static int build(packed *p, const struct RTCBuildPrimitive *primitives, feeler_error *error) {
    RTCDevice device = rtcNewDevice(NULL);
    RTCBVH bvh = device ? rtcNewBVH(device) : NULL;
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = 64;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = MOST_IN_LEAF;
    arguments.bvh = bvh;
    arguments.primitives = (struct RTCBuildPrimitive *)primitives;
    arguments.primitiveCount = arguments.primitiveArrayCapacity = p->bounded;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    const branch *root = bvh ? rtcBuildBVH(&arguments) : NULL;
    int status = -1;
    if (!root)
        fail(error,
             device && rtcGetDeviceError(device) != RTC_ERROR_OUT_OF_MEMORY ? FEELER_DEVICE : FEELER_OUT_OF_MEMORY,
             "Embree could not build a tree over %zu primitives", p->bounded);
    else if (reserve(&p->arrays[ARRAY_NODES], 2 * p->bounded, error) == 0 &&
             reserve(&p->arrays[ARRAY_LINKS], 2 * p->bounded, error) == 0) {
        uint32_t next_entry = 0;
        flatten(p, root, &next_entry);
        p->arrays[ARRAY_LINKS].count = p->arrays[ARRAY_NODES].count;
        status = 0;
    }
    if (bvh)
        rtcReleaseBVH(bvh);
    if (device)
        rtcReleaseDevice(device);
    return status;
}

/* Bounded primitives first, in their own order; then the planes. */
static int fill_order(packed *p, feeler_error *error) {
    size_t count = p->arrays[ARRAY_PRIMITIVES].count;
    const uint4 *primitives = p->arrays[ARRAY_PRIMITIVES].data;
    uint32_t *order = array_add(&p->arrays[ARRAY_ORDER], count, error);
    if (!order && count)
        return -1;
    size_t last = count;
    for (size_t i = count; i-- > 0;)
        if (primitives[i].x == KIND_PLANE)
            order[--last] = (uint32_t)i;
    p->bounded = 0;
    for (size_t i = 0; i < count; i++)
        if (primitives[i].x != KIND_PLANE)
            order[p->bounded++] = (uint32_t)i;
    return 0;
}

int build_tree(packed *p, bool brute_force, feeler_error *error) {
    double start = seconds_now();
    if (fill_order(p, error) < 0)
        return -1;
    if (brute_force || p->bounded == 0)
        return 0;
    struct RTCBuildPrimitive *primitives = build_primitives(p, p->arrays[ARRAY_ORDER].data, error);
    int status = primitives ? build(p, primitives, error) : -1;
    free(primitives);
    p->tree_seconds = seconds_now() - start;
    return status;
}
