/* tree.c - the tree over the bounded primitives: its shape by Embree's builder, its boxes ours. */
#include "blocks.h"
#include "clock.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* kernels/tree.cl has room for WIDTH - 1 waiting children of each level, and of the one that splits a leaf by kind. */
enum { MOST_LEVELS = 20 };

/* What Embree builds. A leaf may mix kinds of primitives; a block cannot. */
typedef struct branch {
    size_t count; /* primitives, 0 for an inner node */
    union {
        struct branch *children[WIDTH];
        uint32_t numbers[WIDTH];
    };
} branch;

static void *create_node(RTCThreadLocalAllocator allocator, unsigned int count, void *user) {
    (void)count, (void)user;
    branch *b = rtcThreadLocalAlloc(allocator, sizeof *b, 16);
    if (b)
        *b = (branch){0};
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
    branch *b = count <= WIDTH ? rtcThreadLocalAlloc(allocator, sizeof *b, 16) : NULL;
    if (!b)
        return NULL;
    b->count = count;
    for (size_t i = 0; i < count; i++)
        b->numbers[i] = primitives[i].primID;
    return b;
}

static float lower(double x) {
    float near = (float)x;
    return (double)near <= x ? near : nextafterf(near, -INFINITY);
}

static float upper(double x) {
    float near = (float)x;
    return (double)near >= x ? near : nextafterf(near, INFINITY);
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

static void set_child(packed *p, size_t index, size_t child, bounds box, link l) {
    node *n = (node *)p->arrays[ARRAY_NODES].data + index;
    ((link *)p->arrays[ARRAY_LINKS].data)[index * WIDTH + child] = l;
    const double low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
    for (int axis = 0; axis < 3; axis++) {
        n->rows[axis][child] = low[axis];
        n->rows[3 + axis][child] = high[axis];
    }
}

/* A box that no ray enters before the end of all distances. */
static bounds nowhere(void) {
    return (bounds){{INFINITY, INFINITY, INFINITY, 0}, {INFINITY, INFINITY, INFINITY, 0}};
}

static size_t add_node(packed *p) {
    size_t index = p->arrays[ARRAY_NODES].count++;
    p->arrays[ARRAY_LINKS].count += WIDTH;
    for (size_t i = 0; i < WIDTH; i++)
        set_child(p, index, i, nowhere(), (link){0, 0});
    return index;
}

/* A leaf's blocks as children of a node from `child` on; returns the next child. */
static size_t add_leaf(packed *p, size_t index, size_t child, const branch *leaf) {
    for (size_t i = 0, n; i < leaf->count; i += n) {
        n = run_length(p, leaf->numbers + i, leaf->count - i);
        bounds box = numbers_bounds(p, leaf->numbers + i, n);
        set_child(p, index, child++, box, add_block(p, leaf->numbers + i, n));
    }
    return child;
}

/* Writes a branch as a node, and what is below it; returns its box. A leaf's blocks become the node's own children where
 * there is room, else a node between. */
static bounds flatten(packed *p, branch *b, size_t *written) {
    size_t index = *written = add_node(p), child = 0, room = WIDTH;
    bounds box = empty_bounds();
    if (b->count) {
        group_by_tag(p, b->numbers, b->count);
        add_leaf(p, index, 0, b);
        return numbers_bounds(p, b->numbers, b->count);
    }
    for (size_t i = 0; i < WIDTH && b->children[i]; i++)
        room--;
    for (size_t i = 0; i < WIDTH && b->children[i]; i++) {
        branch *c = b->children[i];
        size_t groups = c->count ? group_by_tag(p, c->numbers, c->count) : 0, below;
        if (groups && groups - 1 <= room) {
            room -= groups - 1;
            child = add_leaf(p, index, child, c);
            box = join(box, numbers_bounds(p, c->numbers, c->count));
        } else {
            bounds inner = flatten(p, c, &below);
            set_child(p, index, child++, inner, (link){(uint32_t)below, LINK_NODE});
            box = join(box, inner);
        }
    }
    return box;
}

static int build(packed *p, const struct RTCBuildPrimitive *primitives, feeler_error *error) {
    RTCDevice device = rtcNewDevice(NULL);
    RTCBVH bvh = device ? rtcNewBVH(device) : NULL;
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = WIDTH;
    arguments.maxDepth = MOST_LEVELS;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = WIDTH;
    arguments.sahBlockSize = WIDTH / 2; /* a block costs one ray as much as one primitive, a packet more */
    arguments.bvh = bvh;
    arguments.primitives = (struct RTCBuildPrimitive *)primitives;
    arguments.primitiveCount = arguments.primitiveArrayCapacity = p->bounded;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    branch *root = bvh ? rtcBuildBVH(&arguments) : NULL;
    int status = -1;
    if (!root)
        fail(error,
             device && rtcGetDeviceError(device) != RTC_ERROR_OUT_OF_MEMORY ? FEELER_DEVICE : FEELER_OUT_OF_MEMORY,
             "Embree could not build a tree over %zu primitives", p->bounded);
    else if (array_reserve(&p->arrays[ARRAY_NODES], p->bounded + 1, error) == 0 &&
             array_reserve(&p->arrays[ARRAY_LINKS], WIDTH * (p->bounded + 1), error) == 0) {
        size_t top;
        flatten(p, root, &top);
        status = 0;
    }
    if (bvh)
        rtcReleaseBVH(bvh);
    if (device)
        rtcReleaseDevice(device);
    return status;
}

/* The bounded primitives' numbers; to be freed. */
static uint32_t *list_bounded(packed *p, feeler_error *error) {
    size_t count = p->arrays[ARRAY_PRIMITIVES].count;
    const uint4 *primitives = p->arrays[ARRAY_PRIMITIVES].data;
    uint32_t *numbers = malloc((count ? count : 1) * sizeof *numbers);
    if (!numbers) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for %zu primitives", count);
        return NULL;
    }
    for (size_t i = 0; i < count; i++)
        if (primitives[i].x != KIND_PLANE)
            numbers[p->bounded++] = (uint32_t)i;
    return numbers;
}

static int build_over(packed *p, const uint32_t *numbers, feeler_error *error) {
    struct RTCBuildPrimitive *primitives = build_primitives(p, numbers, error);
    int status = primitives ? build(p, primitives, error) : -1;
    free(primitives);
    return status;
}

int build_tree(packed *p, bool brute_force, feeler_error *error) {
    double start = seconds_now();
    uint32_t *numbers = list_bounded(p, error);
    int status = numbers ? 0 : -1;
    if (status == 0 && p->bounded) {
        status = reserve_blocks(p, error);
        if (status == 0)
            status = brute_force ? list_blocks(p, numbers, error) : build_over(p, numbers, error);
    }
    free(numbers);
    if (status == 0)
        status = list_planes(p, error);
    p->tree_seconds = seconds_now() - start;
    return status;
}
