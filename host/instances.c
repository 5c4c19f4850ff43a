/* instances.c - groups on the device, and where they are placed. */
#include "blocks.h"
#include "transform.h"
#include "vec.h"

#include <math.h>
#include <stdlib.h>

/* Whether any material lets rays through: an instance may give it to any object of a group. */
static bool any_transmits(const feeler_scene *scene) {
    for (size_t i = 0; i < scene->material_count; i++)
        if (!is_black(scene->materials[i].transmission))
            return true;
    return false;
}

/* A group's objects, about an origin of their own. */
static int pack_group(packed *p, packed_group *to, const scene_group *group, bool transmits, feeler_error *error) {
    vec3 origin = p->origin;
    int status = 0;
    to->first = p->arrays[ARRAY_PRIMITIVES].count;
    to->origin = p->origin = origin_of_group(group);
    for (size_t i = 0; status == 0 && i < group->object_count; i++)
        status = pack_object(p, &group->objects[i], transmits, error);
    to->count = p->arrays[ARRAY_PRIMITIVES].count - to->first;
    p->origin = origin;
    return status;
}

static bounds group_bounds(const packed *p, const packed_group *group) {
    bounds box = empty_bounds();
    for (size_t i = 0; i < group->count; i++)
        box = join(box, primitive_bounds(p, group->first + i));
    return box;
}

static matrix round_linear(const packed *p, const matrix *m) {
    matrix out = {{{0}}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out.m[i][j] = rounded(p, m->m[i][j]);
    return out;
}

/* The power of two k with k <= the greatest element's size < 2 k. */
static double unit_of(const matrix *m) {
    double extent = 0;
    int exponent;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            extent = fmax(extent, fabs(m->m[i][j]));
    frexp(extent, &exponent);
    return ldexp(1, exponent - 1);
}

/* What rounding may take of a point within `reach` of the offset, on the way to the group and back. */
static vec3 rounding_of(const matrix *to_world, const matrix *to_object, vec3 reach) {
    matrix out = *to_world, back = *to_object;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            out.m[i][j] = j < 3 ? fabs(out.m[i][j]) : 0;
            back.m[i][j] = fabs(back.m[i][j]);
        }
    return matrix_apply(&out, matrix_apply(&back, matrix_apply(&out, reach)));
}

/* The box in the world of what a ray meets in the group: that of the map as the device has it, which is the inverse of the
 * rounded `to_object`. */
static bounds world_bounds(const packed *p, const matrix *to_world, const matrix *to_object, bounds box) {
    vec3 low = {box.low.x, box.low.y, box.low.z}, high = {box.high.x, box.high.y, box.high.z};
    vec3 reach = {fmax(fabs(low.x), fabs(high.x)), fmax(fabs(low.y), fabs(high.y)), fmax(fabs(low.z), fabs(high.z))};
    vec3 pad = vec_scale(rounding_of(to_world, to_object, reach), p->is_double ? 0x1p-49 : 0x1p-20);
    matrix_apply_to_box(to_world, &low, &high);
    return pack_bounds(p, vec_subtract(low, pad), vec_add(high, pad));
}

static real4 row(const packed *p, const matrix *m, int i, double w) {
    return pack4(p, (vec3){m->m[i][0], m->m[i][1], m->m[i][2]}, w);
}

static void place_group(const packed *p, instance *out, const matrix *m, const packed_group *group, bounds box) {
    const matrix inverse = matrix_inverse_linear(m);
    const matrix to_object = round_linear(p, &inverse);
    const vec3 offset = vec_subtract(matrix_apply(m, group->origin), p->origin);
    const double unit = unit_of(&to_object);
    matrix to_world = matrix_inverse_linear(&to_object);
    to_world.m[0][3] = rounded(p, offset.x);
    to_world.m[1][3] = rounded(p, offset.y);
    to_world.m[2][3] = rounded(p, offset.z);
    *out = (instance){
        .to_world_x = row(p, &to_world, 0, to_world.m[0][3]),
        .to_world_y = row(p, &to_world, 1, to_world.m[1][3]),
        .to_world_z = row(p, &to_world, 2, to_world.m[2][3]),
        .to_object_x = row(p, &to_object, 0, !matrix_translates(m)),
        .to_object_y = row(p, &to_object, 1, unit),
        .to_object_z = row(p, &to_object, 2, 1 / unit),
        .bounds = world_bounds(p, &to_world, &to_object, box),
    };
}

int pack_groups(packed *p, const feeler_scene *scene, feeler_error *error) {
    bool transmits = any_transmits(scene);
    bounds *boxes = calloc(scene->group_count + 1, sizeof *boxes);
    p->groups = calloc(scene->group_count + 1, sizeof *p->groups);
    p->group_count = scene->group_count;
    int status = boxes && p->groups ? 0 : fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0, at = 0; status == 0 && i < scene->object_count; i++) {
        const scene_object *object = &scene->objects[i];
        if (object->shape != SHAPE_INSTANCE || scene->groups[object->instance.group].object_count == 0)
            continue;
        int index = object->instance.group;
        packed_group *group = &p->groups[index];
        if (!group->count) {
            status = pack_group(p, group, &scene->groups[index], transmits, error);
            boxes[index] = group_bounds(p, group);
        }
        instance *out = (instance *)p->arrays[ARRAY_INSTANCES].data + at;
        ((uint4 *)p->arrays[ARRAY_INSTANCE_ROOTS].data)[at++].z = (uint32_t)index;
        place_group(p, out, &object->instance.matrix, group, boxes[index]);
    }
    free(boxes);
    return status;
}
