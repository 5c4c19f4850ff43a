/* blocks.c - the leaves of the tree: primitives of one kind side by side, as kernels/block.cl reads them. */
#include "blocks.h"

#include <math.h>

bounds empty_bounds(void) {
    return (bounds){{INFINITY, INFINITY, INFINITY, 0}, {-INFINITY, -INFINITY, -INFINITY, 0}};
}

/* Not fmin and fmax: these are calls, and nothing here is not a number. */
static real least(real a, real b) {
    return a < b ? a : b;
}
static real greatest(real a, real b) {
    return a > b ? a : b;
}

bounds join(bounds a, bounds b) {
    return (bounds){{least(a.low.x, b.low.x), least(a.low.y, b.low.y), least(a.low.z, b.low.z), 0},
                    {greatest(a.high.x, b.high.x), greatest(a.high.y, b.high.y), greatest(a.high.z, b.high.z), 0}};
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
    case KIND_INSTANCE:
        return ((const instance *)p->arrays[ARRAY_INSTANCES].data)[index].bounds;
    default:
        return empty_bounds();
    }
}

/* The tag of blocks that may hold this primitive, without the block's number. */
static uint32_t tag_of(const packed *p, uint32_t number) {
    uint4 primitive = ((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[number];
    uint32_t flags = primitive.w & (FLAG_BACK_HIDDEN | FLAG_FRONT_HIDDEN | FLAG_CAPPED);
    return primitive.x << TAG_KIND | flags << TAG_FLAGS;
}

/* Instances are met one by one. */
static bool share_block(const packed *p, uint32_t a, uint32_t b) {
    return tag_of(p, a) == tag_of(p, b) && tag_of(p, a) >> TAG_KIND != KIND_INSTANCE;
}

/* Sorts by tag, then by number; returns how many groups there are. */
size_t group_by_tag(const packed *p, uint32_t *numbers, size_t count) {
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
        groups += !share_block(p, numbers[i], numbers[i - 1]);
    return groups;
}

size_t run_length(const packed *p, const uint32_t *numbers, size_t count) {
    size_t n = 1;
    while (n < count && share_block(p, numbers[n], numbers[0]))
        n++;
    return n;
}

/* A primitive's fields as blocks have them; returns how many. */
static size_t block_fields(const packed *p, uint32_t number, real fields[ROWS_CONE]) {
    uint4 primitive = ((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[number];
    bounds b = primitive_bounds(p, number);
    size_t n = 0;
#define PUT3(v) (fields[n++] = (v).x, fields[n++] = (v).y, fields[n++] = (v).z)
    if (primitive.x != KIND_TRIANGLE && primitive.x != KIND_INSTANCE) {
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

/* A block of up to `width` primitives of one tag. */
link add_block(packed *p, const uint32_t *numbers, size_t count) {
    array *blocks = &p->arrays[ARRAY_BLOCKS], *all = &p->arrays[ARRAY_BLOCK_NUMBERS];
    link l = {(uint32_t)blocks->count, tag_of(p, numbers[0]) | (uint32_t)p->blocks++};
    real fields[ROWS_CONE], *out = (real *)blocks->data + blocks->count * p->width;
    for (size_t i = 0; i < p->width; i++) {
        uint32_t number = numbers[i < count ? i : count - 1];
        size_t n = block_fields(p, number, fields);
        for (size_t f = 0; f < n; f++)
            out[f * p->width + i] = fields[f];
        ((uint32_t *)all->data)[all->count++] = number;
        if (i == 0)
            blocks->count += n;
    }
    return l;
}

bounds numbers_bounds(const packed *p, const uint32_t *numbers, size_t count) {
    bounds box = empty_bounds();
    for (size_t i = 0; i < count; i++)
        box = join(box, primitive_bounds(p, numbers[i]));
    return box;
}

/* Rows that the primitives take; each is alone in its block at worst. */
static size_t count_rows(const packed *p, const uint32_t *numbers, size_t count) {
    static const uint8_t rows[] = {
        [KIND_SPHERE] = ROWS_SPHERE,   [KIND_DISC] = ROWS_DISC, [KIND_BOX] = ROWS_BOX, [KIND_TRIANGLE] = ROWS_TRIANGLE,
        [KIND_POLYGON] = ROWS_POLYGON, [KIND_CONE] = ROWS_CONE, [KIND_INSTANCE] = 0,
    };
    size_t sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += rows[((const uint4 *)p->arrays[ARRAY_PRIMITIVES].data)[numbers[i]].x];
    return sum;
}

int reserve_blocks(packed *p, const uint32_t *numbers, size_t count, feeler_error *error) {
    if (array_reserve(&p->arrays[ARRAY_BLOCKS], count_rows(p, numbers, count), error) < 0)
        return -1;
    return array_reserve(&p->arrays[ARRAY_BLOCK_NUMBERS], count * p->width, error);
}

int list_blocks(packed *p, const uint32_t *numbers, size_t count, feeler_error *error) {
    for (size_t i = 0, n; i < count; i += n) {
        n = run_length(p, numbers + i, count - i);
        n = n < p->width ? n : p->width;
        link *l = array_add(&p->arrays[ARRAY_LINKS], 1, error);
        if (!l)
            return -1;
        *l = add_block(p, numbers + i, n);
    }
    return 0;
}
