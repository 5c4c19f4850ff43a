/* pixel_origin.c - which object of the scene a primitive is from: pack.c and instances.c put them in the objects' order. */
#include "pixel.h"

#include <stdio.h>
#include <stdlib.h>

static size_t primitives_of(const feeler_scene *scene, const scene_object *object) {
    if (object->shape == SHAPE_INSTANCE && scene->groups[object->instance.group].object_count == 0)
        return 0;
    return object->shape == SHAPE_MESH ? object->mesh.triangle_count : 1;
}

/* Of the scene's objects (list 0) or a group's, made when they are first asked for. */
static const size_t *starts_of(const story *t, size_t list, const scene_object *objects, size_t count,
                               feeler_error *error) {
    if (t->starts[list])
        return t->starts[list];
    size_t *starts = malloc((count + 1) * sizeof *starts);
    if (!starts) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
        return NULL;
    }
    starts[0] = 0;
    for (size_t i = 0; i < count; i++)
        starts[i + 1] = starts[i] + primitives_of(t->scene, &objects[i]);
    t->starts[list] = starts;
    return starts;
}

/* The last object that begins at or before the primitive: those without primitives begin where the next one does. */
static size_t find_object(const size_t *starts, size_t count, size_t primitive) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (starts[middle] <= primitive)
            low = middle;
        else
            high = middle;
    }
    return low;
}

int find_origin(const story *t, uint4 met, origin *o, feeler_error *error) {
    const feeler_scene *scene = t->scene;
    const size_t *starts = starts_of(t, 0, scene->objects, scene->object_count, error);
    if (!starts)
        return -1;
    *o = (origin){.number = find_object(starts, scene->object_count, met.x)};
    o->object = &scene->objects[o->number];
    o->triangle = met.x - starts[o->number];
    if (o->object->shape != SHAPE_INSTANCE)
        return 0;
    const size_t index = (size_t)o->object->instance.group;
    const scene_group *group = &scene->groups[index];
    const size_t primitive = met.y - t->job->packed.groups[index].first;
    starts = starts_of(t, 1 + index, group->objects, group->object_count, error);
    if (!starts)
        return -1;
    o->inside_number = find_object(starts, group->object_count, primitive);
    o->inside = &group->objects[o->inside_number];
    o->triangle = primitive - starts[o->inside_number];
    return 0;
}

json_t *place_json(place place) {
    char text[1024];
    if (!place.source)
        return json_null();
    if (place.line > 0)
        snprintf(text, sizeof text, "%.900s:%d:%d", place.source, place.line, place.column);
    else
        snprintf(text, sizeof text, "%.900s", place.source);
    return text_json(text);
}

static json_t *object_json(const scene_object *object, size_t number, size_t triangle) {
    static const char *const shapes[] = {
        [SHAPE_SPHERE] = "sphere", [SHAPE_PLANE] = "plane",       [SHAPE_DISC] = "disc",
        [SHAPE_BOX] = "box",       [SHAPE_TRIANGLE] = "triangle", [SHAPE_POLYGON] = "polygon",
        [SHAPE_CONE] = "cone",     [SHAPE_MESH] = "mesh",         [SHAPE_INSTANCE] = "instance",
    };
    json_t *json = json_pack("{s: I, s: s, s: o}", "number", (json_int_t)number, "shape", shapes[object->shape],
                             "place", place_json(object->place));
    if (object->shape == SHAPE_MESH)
        json_object_set_new(json, "triangle", json_integer((json_int_t)triangle));
    return json;
}

json_t *origin_json(const origin *o) {
    json_t *json = object_json(o->object, o->number, o->triangle);
    if (o->inside)
        json_object_set_new(json, "inside", object_json(o->inside, o->inside_number, o->triangle));
    return json;
}
