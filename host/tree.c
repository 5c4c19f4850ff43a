/* tree.c - the tree over the bounded primitives: its shape by Embree's builder, its boxes ours. */
#include "blocks.h"
#include "clock.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* kernels/tree.cl has room for width - 1 waiting children of each level, and of the one that splits a leaf by kind. */
enum { MOST_LEVELS = 20 };

/* What Embree builds. A leaf may mix kinds of primitives; a block cannot. */
typedef struct branch {
    size_t count; /* primitives, 0 for an inner node */
    union {
        struct branch *children[MOST_WIDTH];
        uint32_t numbers[MOST_WIDTH];
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
    branch *b = count <= MOST_WIDTH ? rtcThreadLocalAlloc(allocator, sizeof *b, 16) : NULL;
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

static struct RTCBuildPrimitive *build_primitives(const packed *p, const uint32_t *numbers, size_t count,
                                                  feeler_error *error) {
    struct RTCBuildPrimitive *out = aligned_alloc(32, (count ? count : 1) * sizeof *out);
    if (!out) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a tree over %zu primitives", count);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        bounds b = primitive_bounds(p, numbers[i]);
        out[i] = (struct RTCBuildPrimitive){
            .lower_x = lower(b.low.x),
            .lower_y = lower(b.low.y),
            .lower_z = lower(b.low.z),
            .upper_x = upper(b.high.x),
            .upper_y = upper(b.high.y),
            .upper_z = upper(b.high.z),
            .geomID = 0,
            .primID = numbers[i],
        };
    }
    return out;
}

static void set_child(packed *p, size_t index, size_t child, bounds box, link l) {
    real *rows = (real *)p->arrays[ARRAY_NODES].data + index * NODE_ROWS * p->width;
    ((link *)p->arrays[ARRAY_LINKS].data)[index * p->width + child] = l;
    const double low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
    for (int axis = 0; axis < 3; axis++) {
        rows[(size_t)axis * p->width + child] = low[axis];
        rows[(size_t)(3 + axis) * p->width + child] = high[axis];
    }
}

/* A box that no ray enters before the end of all distances. */
static bounds nowhere(void) {
    return (bounds){{INFINITY, INFINITY, INFINITY, 0}, {INFINITY, INFINITY, INFINITY, 0}};
}

static size_t add_node(packed *p) {
    size_t index = p->arrays[ARRAY_NODES].count++;
    p->arrays[ARRAY_LINKS].count += p->width;
    for (size_t i = 0; i < p->width; i++)
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
    size_t index = *written = add_node(p), child = 0, room = p->width;
    bounds box = empty_bounds();
    if (b->count) {
        group_by_tag(p, b->numbers, b->count);
        add_leaf(p, index, 0, b);
        return numbers_bounds(p, b->numbers, b->count);
    }
    for (size_t i = 0; i < p->width && b->children[i]; i++)
        room--;
    for (size_t i = 0; i < p->width && b->children[i]; i++) {
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

/* A tree over so many primitives; returns its root's node in `top`. */
static int build(packed *p, RTCDevice device, const struct RTCBuildPrimitive *primitives, size_t count, size_t *top,
                 feeler_error *error) {
    RTCBVH bvh = device ? rtcNewBVH(device) : NULL;
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = (unsigned)p->width;
    arguments.maxDepth = MOST_LEVELS;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = (unsigned)p->width;
    arguments.sahBlockSize = (unsigned)p->width / 2; /* a block costs one ray as much as one primitive, a packet more */
    arguments.bvh = bvh;
    arguments.primitives = (struct RTCBuildPrimitive *)primitives;
    arguments.primitiveCount = arguments.primitiveArrayCapacity = count;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    branch *root = bvh ? rtcBuildBVH(&arguments) : NULL;
    int status = -1;
    if (!root)
        fail(error,
             device && rtcGetDeviceError(device) != RTC_ERROR_OUT_OF_MEMORY ? FEELER_DEVICE : FEELER_OUT_OF_MEMORY,
             "Embree could not build a tree over %zu primitives", count);
    else if (array_reserve(&p->arrays[ARRAY_NODES], count + 1, error) == 0 &&
             array_reserve(&p->arrays[ARRAY_LINKS], p->width * (count + 1), error) == 0) {
        flatten(p, root, top);
        status = 0;
    }
    if (bvh)
        rtcReleaseBVH(bvh);
    return status;
}

/* A tree over the primitives, or without one blocks; `root` and `end` as in packed_group. */
static int build_over(packed *p, RTCDevice device, const uint32_t *numbers, size_t count, uint32_t *root, uint32_t *end,
                      feeler_error *error) {
    size_t top = p->arrays[ARRAY_LINKS].count;
    if (reserve_blocks(p, numbers, count, error) < 0)
        return -1;
    int status = -1;
    if (device) {
        struct RTCBuildPrimitive *primitives = build_primitives(p, numbers, count, error);
        status = primitives ? build(p, device, primitives, count, &top, error) : -1;
        free(primitives);
    } else {
        status = list_blocks(p, numbers, count, error);
    }
    *root = (uint32_t)top;
    *end = (uint32_t)(device ? top + 1 : p->arrays[ARRAY_LINKS].count);
    return status;
}

/* The scene's own: the planes' numbers follow the blocks', in blocks too if others come after. */
static int build_own(packed *p, RTCDevice device, uint32_t *numbers, feeler_error *error) {
    const uint4 *primitives = p->arrays[ARRAY_PRIMITIVES].data;
    size_t bounded = 0;
    uint32_t root, end;
    for (size_t i = 0; i < p->own; i++)
        if (primitives[i].x != KIND_PLANE)
            numbers[bounded++] = (uint32_t)i;
    if (bounded && build_over(p, device, numbers, bounded, &root, &end, error) < 0)
        return -1;
    p->own_blocks = p->blocks;
    p->planes = p->own - bounded;
    size_t room = p->group_count ? (p->planes + p->width - 1) / p->width * p->width : p->planes;
    uint32_t *planes = array_add(&p->arrays[ARRAY_BLOCK_NUMBERS], room, error);
    for (size_t i = 0; planes && i < p->own; i++)
        if (primitives[i].x == KIND_PLANE)
            *planes++ = (uint32_t)i;
    p->blocks += (room + p->width - 1) / p->width;
    return planes ? 0 : -1;
}

static int build_groups(packed *p, RTCDevice device, uint32_t *numbers, feeler_error *error) {
    for (size_t i = 0; i < p->group_count; i++) {
        packed_group *g = &p->groups[i];
        for (size_t k = 0; k < g->count; k++)
            numbers[k] = (uint32_t)(g->first + k);
        if (g->count && build_over(p, device, numbers, g->count, &g->root, &g->end, error) < 0)
            return -1;
    }
    uint4 *roots = p->arrays[ARRAY_INSTANCE_ROOTS].data;
    for (size_t i = 0; i < p->arrays[ARRAY_INSTANCE_ROOTS].count; i++) {
        const packed_group *g = &p->groups[roots[i].z];
        roots[i] = (uint4){g->root, g->end, 0, 0};
    }
    return 0;
}

int build_trees(packed *p, bool brute_force, feeler_error *error) {
    double start = seconds_now();
    size_t count = p->arrays[ARRAY_PRIMITIVES].count;
    RTCDevice device = brute_force || count == 0 ? NULL : rtcNewDevice(NULL);
    uint32_t *numbers = malloc((count ? count : 1) * sizeof *numbers);
    int status = -1;
    if (!numbers || (count && !brute_force && !device))
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a tree over %zu primitives", count);
    else if (build_own(p, device, numbers, error) == 0)
        status = build_groups(p, device, numbers, error);
    if (status == 0 && p->blocks > TAG_NUMBER)
        status = fail(error, FEELER_BAD_INPUT, "the scene has %zu blocks of primitives, but can have %u", p->blocks,
                      TAG_NUMBER);
    free(numbers);
    if (device)
        rtcReleaseDevice(device);
    p->tree_seconds = seconds_now() - start;
    return status;
}
