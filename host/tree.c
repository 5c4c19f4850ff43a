/* tree.c - the tree over the bounded primitives: its shape by Embree's builder, its boxes ours. */
#include "clock.h"
#include "packed.h"

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

/* Where the tree's nodes lead to: a node's number or a block. */
typedef struct link {
    uint32_t place, tag;
} link;

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

/* The tag of blocks that may hold this primitive, without the block's number. */
static uint32_t tag_of(const packed *p, uint32_t number) {
    uint4 primitive = ((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[number];
    uint32_t flags = primitive.w & (FLAG_BACK_HIDDEN | FLAG_FRONT_HIDDEN | FLAG_CAPPED);
    return primitive.x << TAG_KIND | flags << TAG_FLAGS;
}

/* Sorts by tag, then by number; returns how many tags there are. */
static size_t group(const packed *p, uint32_t *numbers, size_t count) {
    size_t groups = count > 0;
    for (size_t i = 1; i < count; i++)
        for (size_t k = i; k > 0; k--) {
            uint32_t a = tag_of(p, numbers[k - 1]), b = tag_of(p, numbers[k]), swap = numbers[k];
            if (a < b || (a == b && numbers[k - 1] <= numbers[k]))
                break;
            numbers[k] = numbers[k - 1];
            numbers[k - 1] = swap;
        }
    for (size_t i = 1; i < count; i++)
        groups += tag_of(p, numbers[i]) != tag_of(p, numbers[i - 1]);
    return groups;
}

/* How many of the numbers, from the first on, share its tag. */
static size_t run_length(const packed *p, const uint32_t *numbers, size_t count) {
    size_t n = 1;
    while (n < count && tag_of(p, numbers[n]) == tag_of(p, numbers[0]))
        n++;
    return n;
}

/* A primitive's fields as blocks have them; returns how many. */
static size_t block_fields(const packed *p, uint32_t number, real fields[ROWS_CONE]) {
    uint4 primitive = ((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[number];
    bounds b = primitive_bounds(p, number);
    size_t n = 0;
#define PUT3(v) (fields[n++] = (v).x, fields[n++] = (v).y, fields[n++] = (v).z)
    if (primitive.x != KIND_TRIANGLE) {
        PUT3(b.low);
        PUT3(b.high);
    }
    switch (primitive.x) {
    case KIND_SPHERE: {
        const sphere *s = (const sphere *)p->arrays[ARRAY_SPHERES].data + primitive.y;
        PUT3(s->centre_radius);
        fields[n++] = s->centre_radius.w;
        break;
    }
    case KIND_DISC: {
        const disc *s = (const disc *)p->arrays[ARRAY_DISCS].data + primitive.y;
        PUT3(s->centre_radius);
        fields[n++] = s->centre_radius.w;
        PUT3(s->normal);
        break;
    }
    case KIND_TRIANGLE: {
        uint4 t = ((const uint4 *)p->arrays[ARRAY_TRIANGLES].data)[primitive.y];
        const real4 *v = p->arrays[ARRAY_VERTICES].data;
        PUT3(v[t.x]);
        PUT3(v[t.y]);
        PUT3(v[t.z]);
        break;
    }
    case KIND_CONE: {
        const cone *s = (const cone *)p->arrays[ARRAY_CONES].data + primitive.y;
        PUT3(s->base_radius);
        PUT3(s->u_height);
        PUT3(s->v_slope);
        PUT3(s->axis);
        fields[n++] = s->base_radius.w;
        fields[n++] = s->u_height.w;
        fields[n++] = s->v_slope.w;
        break;
    }
    default:
        break;
    }
#undef PUT3
    return n;
}

/* A block of up to WIDTH primitives of one tag. */
static link add_block(packed *p, const uint32_t *numbers, size_t count) {
    array *blocks = &p->arrays[ARRAY_BLOCKS], *all = &p->arrays[ARRAY_BLOCK_NUMBERS];
    link l = {(uint32_t)blocks->count, tag_of(p, numbers[0]) | (uint32_t)p->blocks++};
    real fields[ROWS_CONE], *out = (real *)blocks->data + blocks->count * WIDTH;
    for (size_t i = 0; i < WIDTH; i++) {
        uint32_t number = numbers[i < count ? i : count - 1];
        size_t n = block_fields(p, number, fields);
        for (size_t f = 0; f < n; f++)
            out[f * WIDTH + i] = fields[f];
        ((uint32_t *)all->data)[all->count++] = number;
        if (i == 0)
            blocks->count += n;
    }
    return l;
}

static bounds numbers_bounds(const packed *p, const uint32_t *numbers, size_t count) {
    bounds box = empty_bounds();
    for (size_t i = 0; i < count; i++)
        box = join(box, primitive_bounds(p, numbers[i]));
    return box;
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
        group(p, b->numbers, b->count);
        add_leaf(p, index, 0, b);
        return numbers_bounds(p, b->numbers, b->count);
    }
    for (size_t i = 0; i < WIDTH && b->children[i]; i++)
        room--;
    for (size_t i = 0; i < WIDTH && b->children[i]; i++) {
        branch *c = b->children[i];
        size_t groups = c->count ? group(p, c->numbers, c->count) : 0, below;
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

/* Room first, so that nothing fails on the way. */
static int reserve(array *a, size_t count, feeler_error *error) {
    if (!array_add(a, count, error))
        return -1;
    a->count = 0;
    return 0;
}

/* Fields that all bounded primitives together have; each is alone in its block at worst. */
static size_t count_fields(const packed *p) {
    const array *a = p->arrays;
    return a[ARRAY_SPHERES].count * ROWS_SPHERE + a[ARRAY_DISCS].count * ROWS_DISC + a[ARRAY_BOXES].count * ROWS_BOX +
           a[ARRAY_TRIANGLES].count * ROWS_TRIANGLE + a[ARRAY_POLYGONS].count * ROWS_POLYGON +
           a[ARRAY_CONES].count * ROWS_CONE;
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
    else if (reserve(&p->arrays[ARRAY_NODES], p->bounded + 1, error) == 0 &&
             reserve(&p->arrays[ARRAY_LINKS], WIDTH * (p->bounded + 1), error) == 0) {
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

/* Without a tree: blocks of neighbours in the list. */
static int list_blocks(packed *p, const uint32_t *numbers, feeler_error *error) {
    for (size_t i = 0, n; i < p->bounded; i += n) {
        n = run_length(p, numbers + i, p->bounded - i);
        n = n < WIDTH ? n : WIDTH;
        link *l = array_add(&p->arrays[ARRAY_LINKS], 1, error);
        if (!l)
            return -1;
        *l = add_block(p, numbers + i, n);
    }
    return 0;
}

static int list_planes(packed *p, feeler_error *error) {
    const uint4 *primitives = p->arrays[ARRAY_PRIMITIVES].data;
    for (size_t i = 0; i < p->arrays[ARRAY_PRIMITIVES].count; i++)
        if (primitives[i].x == KIND_PLANE) {
            uint32_t *number = array_add(&p->arrays[ARRAY_BLOCK_NUMBERS], 1, error);
            if (!number)
                return -1;
            *number = (uint32_t)i;
        }
    return 0;
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
        status = reserve(&p->arrays[ARRAY_BLOCKS], count_fields(p), error);
        if (status == 0)
            status = reserve(&p->arrays[ARRAY_BLOCK_NUMBERS], p->bounded * WIDTH, error);
        if (status == 0)
            status = brute_force ? list_blocks(p, numbers, error) : build_over(p, numbers, error);
    }
    free(numbers);
    if (status == 0)
        status = list_planes(p, error);
    p->tree_seconds = seconds_now() - start;
    return status;
}
