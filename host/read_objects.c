/* read_objects.c - materials, lights and objects of a scene from nodes. */
#include "schema.h"
#include "transform.h"
#include "vec.h"

#include <stdlib.h>
#include <string.h>

/* ---- materials ---- */

int read_material(reader *reader, const feeler_node *node, const char *name) {
    scene_material *material = scene_add_material(reader->scene, reader->error);
    if (!material || keep_place(reader, node, &material->place) != 0)
        return -1;
    int index = (int)reader->scene->material_count - 1;
    if (name) {
        material->name = strdup(name);
        if (!material->name)
            return fail_memory(reader);
        int status = name_add(&reader->materials, material->name, index);
        if (status != 0)
            return status > 0 ? fail_key(reader, node, "the material '%.60s' is given twice", name)
                              : fail_memory(reader);
    }
    return schema_read(reader, node, material_keys, material, NULL);
}

static int fail_material(const reader *reader, const feeler_node *node, const char *name) {
    char text[SHOWN_SIZE], hint[SUGGESTION_SIZE];
    suggestion nearest = suggest_for(name);
    for (size_t i = 0; i < reader->materials.capacity; i++)
        if (reader->materials.slots[i].name)
            suggest_candidate(&nearest, reader->materials.slots[i].name);
    return fail_node(reader, node_value(node), "unknown material '%s'%s", shown(name, text),
                     suggest_text(&nearest, hint));
}

/* A matte grey, made when the first object without a material asks for it. */
int read_default_material(reader *reader) {
    if (reader->default_material >= 0)
        return reader->default_material;
    scene_material *material = scene_add_material(reader->scene, reader->error);
    if (!material)
        return -1;
    material->ambient = material->diffuse = (vec3){0.7, 0.7, 0.7};
    reader->default_material = (int)reader->scene->material_count - 1;
    return reader->default_material;
}

/* The index of what a `material` key says: a name, or a material written in place. Negative on failure. */
static int read_material_key(reader *reader, const feeler_node *node) {
    const char *name = "";
    if (node_value(node)->kind == NODE_MAP) {
        int index = (int)reader->scene->material_count;
        return read_material(reader, node, NULL) == 0 ? index : -1;
    }
    if (read_text(reader, node, &name) != 0)
        return -1;
    int index = name_find(&reader->materials, name);
    return index >= 0 ? index : fail_material(reader, node, name);
}

/* ---- lights ---- */

static int read_light_place(const reader *reader, const feeler_node *const *nodes, scene_light *light) {
    const feeler_node *node = nodes[LIGHT_POINT] ? nodes[LIGHT_POINT] : nodes[LIGHT_DIRECTIONAL];
    light->directional = node == nodes[LIGHT_DIRECTIONAL];
    if (read_vector(reader, node, &light->position) != 0)
        return -1;
    if (!light->directional)
        return 0;
    /* Written as the way that the light travels, kept as the way to the light. */
    light->position = vec_scale(light->position, -1);
    return vec_normalize(&light->position) ? 0 : fail_node(reader, node_value(node), "'directional' has length zero");
}

int read_light(reader *reader, const feeler_node *node) {
    const feeler_node *nodes[LIGHT_SLOTS] = {NULL};
    scene_light *light = scene_add_light(reader->scene, reader->error);
    if (!light || keep_place(reader, node, &light->place) != 0)
        return -1;
    const double unset = -1; /* outside the range, so that no file says it */
    vec3 colour = {1, 1, 1};
    light->diffuse.x = light->specular.x = unset;
    if (schema_read(reader, node, light_keys, light, nodes) != 0)
        return -1;
    if (nodes[LIGHT_COLOUR] && schema_read_one(reader, nodes[LIGHT_COLOUR], &light_colour_key, &colour) != 0)
        return -1;
    if (light->diffuse.x == unset)
        light->diffuse = colour;
    if (light->specular.x == unset)
        light->specular = colour;
    if (!nodes[LIGHT_POINT] == !nodes[LIGHT_DIRECTIONAL])
        return fail_node(reader, node_value(node),
                         nodes[LIGHT_POINT] ? "a light is either 'point' or 'directional', not both"
                                            : "a light needs 'point' or 'directional'");
    return read_light_place(reader, nodes, light);
}

/* ---- objects ---- */

static int read_corners(reader *reader, const feeler_node *const *nodes, scene_object *object) {
    vec3 *corners = NULL, *normals = NULL;
    size_t count = 0, normal_count = 0;
    if (read_vectors(reader, nodes[CORNERS], &corners, &count) != 0)
        return -1;
    int status = 0;
    if (nodes[CORNERS_NORMALS])
        status = read_vectors(reader, nodes[CORNERS_NORMALS], &normals, &normal_count);
    if (status == 0 && count != 3)
        status = fail_node(reader, node_value(nodes[CORNERS]), "a triangle has 3 corners, not %zu", count);
    if (status == 0 && normals && normal_count != 3)
        status =
            fail_node(reader, node_value(nodes[CORNERS_NORMALS]), "a triangle has 3 normals, not %zu", normal_count);
    for (size_t i = 0; status == 0 && i < 3; i++) {
        object->triangle.corners[i] = corners[i];
        if (!normals)
            continue;
        if (vec_extent(normals[i]) == 0)
            status = fail_item(reader, node_value(nodes[CORNERS_NORMALS]), i, "the normal has length zero");
        object->triangle.normals[i] = normals[i];
        object->triangle.smooth = true;
    }
    free(corners);
    free(normals);
    return status;
}

static int read_triangle(reader *reader, const feeler_node *node, scene_object *object) {
    const feeler_node *nodes[CORNERS_SLOTS] = {NULL};
    object->shape = SHAPE_TRIANGLE;
    return schema_read(reader, node, triangle_keys, object, nodes) == 0 ? read_corners(reader, nodes, object) : -1;
}

/* The sum over the edges that is twice the area times the normal (Newell), corners taken from the first one. */
static vec3 polygon_area_vector(const vec3 *corners, size_t count) {
    vec3 sum = {0, 0, 0};
    for (size_t i = 1; i + 1 < count; i++)
        sum = vec_add(sum, vec_cross(vec_subtract(corners[i], corners[0]), vec_subtract(corners[i + 1], corners[0])));
    return sum;
}

/* The corner that leaves the plane through the middle by more than a thousandth of the extent, or -1. */
static long corner_off_plane(const vec3 *corners, size_t count) {
    vec3 normal = polygon_area_vector(corners, count);
    if (!vec_normalize(&normal))
        return -1; /* without an area it is dropped later */
    double extent = 0, middle = 0;
    for (size_t i = 0; i < count; i++) {
        vec3 arm = vec_subtract(corners[i], corners[0]);
        extent = fmax(extent, vec_extent(arm));
        middle += vec_dot(arm, normal) / (double)count;
    }
    for (size_t i = 0; i < count; i++)
        if (fabs(vec_dot(vec_subtract(corners[i], corners[0]), normal) - middle) > 1e-3 * extent)
            return (long)i;
    return -1;
}

static int read_polygon(reader *reader, const feeler_node *node, scene_object *object) {
    const feeler_node *nodes[CORNERS_SLOTS] = {NULL};
    object->shape = SHAPE_POLYGON;
    if (schema_read(reader, node, polygon_keys, object, nodes) != 0 ||
        read_vectors(reader, nodes[CORNERS], &object->polygon.corners, &object->polygon.count) != 0)
        return -1;
    if (object->polygon.count < 3)
        return fail_node(reader, node_value(nodes[CORNERS]), "a polygon has at least 3 corners, not %zu",
                         object->polygon.count);
    long off = corner_off_plane(object->polygon.corners, object->polygon.count);
    if (off >= 0)
        return fail_item(reader, node_value(nodes[CORNERS]), (size_t)off,
                         "the polygon is not flat: corner %ld is off its plane", off);
    return 0;
}

/* Shapes whose keys are plain values. */
static const struct plain_shape {
    shape shape;
    const schema_key *keys;
} plain_shapes[OBJECT_SHAPES] = {
    [OBJECT_SPHERE] = {SHAPE_SPHERE, sphere_keys},   [OBJECT_PLANE] = {SHAPE_PLANE, plane_keys},
    [OBJECT_DISC] = {SHAPE_DISC, disc_keys},         [OBJECT_BOX] = {SHAPE_BOX, box_keys},
    [OBJECT_CYLINDER] = {SHAPE_CONE, cylinder_keys}, [OBJECT_CONE] = {SHAPE_CONE, cone_keys},
};

static int append_shape(reader *reader, int slot, const feeler_node *node, int sides, int material, place place) {
    scene_object *object = scene_add_object(reader->scene, reader->error);
    if (!object)
        return -1;
    object->sides = sides;
    object->material = material;
    object->place = place;
    if (slot == OBJECT_TRIANGLE)
        return read_triangle(reader, node, object);
    if (slot == OBJECT_POLYGON)
        return read_polygon(reader, node, object);
    object->shape = plain_shapes[slot].shape;
    schema_set_defaults(plain_shapes[slot].keys, object);
    if (schema_read(reader, node, plain_shapes[slot].keys, object, NULL) != 0)
        return -1;
    if (slot == OBJECT_CYLINDER)
        object->cone.top_radius = object->cone.base_radius;
    return 0;
}

/* The slot of an object's one shape; negative on failure. */
static int find_shape(const reader *reader, const feeler_node *node, const feeler_node *const *nodes) {
    int found = -1;
    for (int slot = 0; slot < OBJECT_SHAPES; slot++) {
        if (nodes[slot] && found >= 0)
            return fail_key(reader, nodes[slot], "an object has one shape, not both '%s' and '%s'", nodes[found]->key,
                            nodes[slot]->key);
        found = nodes[slot] ? slot : found;
    }
    return found >= 0 ? found
                      : fail_node(reader, node_value(node),
                                  "an object needs a shape: sphere, plane, disc, box, triangle, "
                                  "polygon, cylinder, cone, mesh or instance");
}

int read_object(reader *reader, const feeler_node *node) {
    const feeler_node *nodes[OBJECT_SLOTS] = {NULL};
    scene_object common = {.sides = BOTH_SIDES};
    place place;
    if (schema_read(reader, node, object_keys, &common, nodes) != 0)
        return -1;
    int slot = find_shape(reader, node, nodes);
    if (slot < 0 || keep_place(reader, nodes[slot], &place) != 0)
        return -1;
    bool instance = slot == OBJECT_INSTANCE;
    bool own = slot == OBJECT_MESH || instance; /* a mesh file and a group have materials of their own */
    int material = nodes[OBJECT_MATERIAL] ? read_material_key(reader, nodes[OBJECT_MATERIAL])
                   : own                  ? -1
                                          : read_default_material(reader);
    if (material < 0 && (nodes[OBJECT_MATERIAL] || !own))
        return -1;
    matrix matrix = matrix_identity();
    if (nodes[OBJECT_TRANSFORM] && read_transform(reader, nodes[OBJECT_TRANSFORM], &matrix) != 0)
        return -1;
    if (instance && common.sides != BOTH_SIDES)
        return fail_node(reader, node_value(node), "an instance has the sides of its objects: it takes no 'sides'");
    if (instance)
        return read_instance(reader, nodes[slot], &matrix, material, place);
    feeler_scene *scene = reader->scene;
    size_t first = scene->object_count;
    int status = own ? read_mesh(reader, nodes[slot], material, place)
                     : append_shape(reader, slot, nodes[slot], common.sides, material, place);
    for (size_t i = first; status == 0 && i < scene->object_count; i++) {
        scene->objects[i].sides = common.sides;
        if (nodes[OBJECT_TRANSFORM])
            status = transform_object(&matrix, &scene->objects[i], reader->error);
        if (status > 0)
            status = make_instance(scene, i, &matrix, reader->error);
    }
    return status;
}
