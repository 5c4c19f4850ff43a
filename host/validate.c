/* validate.c - the invariant of scene.h: every reader's scene passes here before anything is computed from it. */
#include "mesh.h"
#include "schema.h"
#include "transform.h"
#include "vec.h"

#include <stdio.h>
#include <string.h>

enum { MAX_PIXELS = 1 << 28, MAX_SIDE = 65536 };

static int bad(const scene_object *object, feeler_error *error, const char *text) {
    return fail_at(error, FEELER_BAD_INPUT, object->place, "%s", text);
}

/* ---- camera, image, lights, materials ---- */

static int validate_camera(scene_camera *camera, feeler_error *error) {
    if (schema_check(camera_keys, camera, camera->place, "the camera", error) != 0)
        return -1;
    vec3 view = vec_subtract(camera->look_at, camera->eye);
    if (!vec_normalize(&view))
        return fail_at(error, FEELER_BAD_INPUT, camera->place, "the camera's 'look_at' is its 'eye': it looks nowhere");
    if (!vec_normalize(&camera->up))
        return fail_at(error, FEELER_BAD_INPUT, camera->place, "the camera's 'up' has length zero");
    if (vec_parallel(view, camera->up))
        return fail_at(error, FEELER_BAD_INPUT, camera->place, "the camera's 'up' is parallel to its view");
    return 0;
}

static int validate_image(const feeler_scene *scene, feeler_error *error) {
    place nowhere = {scene->source_count ? scene->sources[0] : NULL, 0, 0};
    if (scene->width < 1 || scene->height < 1 || scene->width > MAX_SIDE || scene->height > MAX_SIDE ||
        (double)scene->width * scene->height > MAX_PIXELS)
        return fail_at(error, FEELER_BAD_INPUT, nowhere,
                       "the image's size %d x %d is not within 1 to %d a side and %d pixels", scene->width,
                       scene->height, MAX_SIDE, MAX_PIXELS);
    if (schema_check(image_keys, scene, nowhere, "the image", error) != 0)
        return -1;
    return schema_check(scene_keys, scene, nowhere, "the scene", error);
}

static int validate_light(scene_light *light, feeler_error *error) {
    if (schema_check(light_keys, light, light->place, "the light", error) != 0)
        return -1;
    if (light->directional && !vec_normalize(&light->position))
        return fail_at(error, FEELER_BAD_INPUT, light->place, "the light's direction has length zero");
    if (!vec_finite(light->position) || vec_extent(light->position) > MAX_COORDINATE)
        return fail_at(error, FEELER_BAD_INPUT, light->place, "the light is farther out than %g", MAX_COORDINATE);
    return 0;
}

static int validate_material(const scene_material *material, feeler_error *error) {
    char what[128];
    snprintf(what, sizeof what, "the material '%.60s'", material->name ? material->name : "");
    return schema_check(material_keys, material, material->place, material->name ? what : "the material", error);
}

/* ---- objects ---- */

static int check_points(const scene_object *object, const vec3 *points, size_t count, feeler_error *error) {
    for (size_t i = 0; i < count; i++)
        if (!vec_finite(points[i]) || vec_extent(points[i]) > MAX_COORDINATE)
            return fail_at(error, FEELER_BAD_INPUT, object->place, "the object reaches farther out than %g",
                           MAX_COORDINATE);
    return 0;
}

static int check_radius(const scene_object *object, double radius, feeler_error *error) {
    if (!(radius > 0))
        return bad(object, error, "the radius must be more than 0");
    if (radius < MIN_LENGTH)
        return fail_at(error, FEELER_BAD_INPUT, object->place, "the radius is too small: at least %g", MIN_LENGTH);
    return radius <= MAX_COORDINATE ? 0 : bad(object, error, "the radius is too large");
}

static int check_normal(const scene_object *object, vec3 *normal, feeler_error *error) {
    return vec_normalize(normal) ? 0 : bad(object, error, "the normal has length zero");
}

static int validate_box(const scene_object *object, feeler_error *error) {
    vec3 low = object->box.low, high = object->box.high;
    if (check_points(object, &low, 1, error) != 0 || check_points(object, &high, 1, error) != 0)
        return -1;
    if (low.x < high.x && low.y < high.y && low.z < high.z)
        return 0;
    return bad(object, error, "the box's 'low' must be below its 'high' in x, y and z");
}

static int validate_cone(const scene_object *object, feeler_error *error) {
    double base = object->cone.base_radius, top = object->cone.top_radius;
    if (check_points(object, &object->cone.base, 1, error) != 0 ||
        check_points(object, &object->cone.top, 1, error) != 0)
        return -1;
    if (!(base >= 0 && top >= 0))
        return bad(object, error, "the radius must not be negative");
    if (base == 0 && top == 0)
        return bad(object, error, "the cone's radii are both 0");
    if ((base > 0 && check_radius(object, base, error) != 0) || (top > 0 && check_radius(object, top, error) != 0))
        return -1;
    double height = vec_length(vec_subtract(object->cone.top, object->cone.base));
    if (height == 0)
        return bad(object, error, "'base' and 'top' are the same point");
    if (height < MIN_LENGTH)
        return fail_at(error, FEELER_BAD_INPUT, object->place, "the height is too small: at least %g", MIN_LENGTH);
    return 0;
}

static int validate_triangle(scene_object *object, feeler_error *error) {
    if (check_points(object, object->triangle.corners, 3, error) != 0)
        return -1;
    for (int i = 0; object->triangle.smooth && i < 3; i++)
        if (check_normal(object, &object->triangle.normals[i], error) != 0)
            return -1;
    return 0;
}

static int validate_polygon(const scene_object *object, feeler_error *error) {
    if (object->polygon.count < 3)
        return bad(object, error, "a polygon has at least 3 corners");
    return check_points(object, object->polygon.corners, object->polygon.count, error);
}

static int validate_mesh(scene_object *object, feeler_error *error) {
    scene_mesh *mesh = &object->mesh;
    if (check_points(object, mesh->vertices, mesh->vertex_count, error) != 0)
        return -1;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
        if (mesh->indices[i] >= mesh->vertex_count)
            return fail_at(error, FEELER_BAD_INPUT, object->place,
                           "triangle %zu: the vertex index %u is out of range; the mesh has %zu vertices, from 0",
                           i / 3, (unsigned)mesh->indices[i], mesh->vertex_count);
    if (!mesh->normals)
        return 0;
    if (mesh_complete_normals(mesh, error) != 0)
        return -1;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        vec_normalize(&mesh->normals[i]);
    return 0;
}

/* The greatest size of a linear part's elements. */
static double linear_extent(const matrix *m) {
    double extent = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            extent = fmax(extent, fabs(m->m[i][j]));
    return extent;
}

static int validate_instance(const feeler_scene *scene, const scene_object *object, feeler_error *error) {
    const matrix *m = &object->instance.matrix;
    if (object->instance.group < 0 || (size_t)object->instance.group >= scene->group_count)
        return bad(object, error, "the instance's group is out of range");
    if (!matrix_finite(m))
        return bad(object, error, "the instance's transform is not finite");
    if (matrix_singular(m))
        return bad(object, error, "the instance's transform is singular: it flattens the object");
    const matrix inverse = matrix_inverse_linear(m);
    if (linear_extent(m) > MAX_COORDINATE || !(linear_extent(&inverse) <= MAX_COORDINATE))
        return fail_at(error, FEELER_BAD_INPUT, object->place,
                       "the instance is scaled by more than %g, or less than %g", MAX_COORDINATE, 1 / MAX_COORDINATE);
    const scene_group *group = &scene->groups[object->instance.group];
    vec3 corners[2] = {group->low, group->high};
    if (group->object_count == 0)
        return 0;
    matrix_apply_to_box(m, &corners[0], &corners[1]);
    return check_points(object, corners, 2, error);
}

static int validate_shape(const feeler_scene *scene, scene_object *object, feeler_error *error) {
    switch (object->shape) {
    case SHAPE_SPHERE:
        return check_radius(object, object->sphere.radius, error) != 0
                   ? -1
                   : check_points(object, &object->sphere.centre, 1, error);
    case SHAPE_PLANE:
        return check_normal(object, &object->plane.normal, error) != 0
                   ? -1
                   : check_points(object, &object->plane.point, 1, error);
    case SHAPE_DISC:
        return check_radius(object, object->disc.radius, error) != 0 ||
                       check_normal(object, &object->disc.normal, error) != 0
                   ? -1
                   : check_points(object, &object->disc.centre, 1, error);
    case SHAPE_BOX:
        return validate_box(object, error);
    case SHAPE_TRIANGLE:
        return validate_triangle(object, error);
    case SHAPE_POLYGON:
        return validate_polygon(object, error);
    case SHAPE_CONE:
        return validate_cone(object, error);
    case SHAPE_MESH:
        return validate_mesh(object, error);
    case SHAPE_INSTANCE:
        return validate_instance(scene, object, error);
    }
    return bad(object, error, "unknown shape");
}

/* ---- degenerate ones ---- */

/* Whether the corners lie on one line: on that through the first corner and the one farthest from it. */
static bool polygon_degenerate(const vec3 *corners, size_t count) {
    size_t far = 0;
    double distance = 0;
    for (size_t i = 1; i < count; i++) {
        double here = vec_length(vec_subtract(corners[i], corners[0]));
        if (here > distance) {
            distance = here;
            far = i;
        }
    }
    for (size_t i = 1; i < count; i++)
        if (!triangle_degenerate(corners[0], corners[far], corners[i]))
            return false;
    return true;
}

/* Takes out what has no area. Returns how many triangles that were; `empty`: nothing of the object is left. */
static size_t drop_degenerate(scene_object *object, bool *empty) {
    const vec3 *corners = object->triangle.corners;
    size_t dropped = 0;
    *empty = false;
    if (object->shape == SHAPE_TRIANGLE) {
        *empty = triangle_degenerate(corners[0], corners[1], corners[2]);
        dropped = *empty;
    } else if (object->shape == SHAPE_POLYGON) {
        *empty = polygon_degenerate(object->polygon.corners, object->polygon.count);
        dropped = *empty;
    } else if (object->shape == SHAPE_MESH) {
        dropped = mesh_drop_degenerate(&object->mesh);
        *empty = object->mesh.triangle_count == 0;
    }
    return dropped;
}

/* The place that holds both: as it is where they are the same, else the file, else unknown. */
static place common_place(place a, place b) {
    if (a.source != b.source)
        return (place){NULL, 0, 0};
    if (a.line == b.line && a.column == b.column)
        return a;
    return (place){a.source, 0, 0};
}

/* What was left out, and where. */
typedef struct losses {
    size_t count;
    place place;
} losses;

static void drop_all_degenerate(scene_object *objects, size_t *count, losses *losses) {
    size_t kept = 0;
    for (size_t i = 0; i < *count; i++) {
        bool empty;
        size_t here = drop_degenerate(&objects[i], &empty);
        if (here > 0)
            losses->place = losses->count == 0 ? objects[i].place : common_place(losses->place, objects[i].place);
        losses->count += here;
        if (empty)
            scene_object_clear(&objects[i]);
        else
            objects[kept++] = objects[i];
    }
    *count = kept;
}

static int warn_of_losses(feeler_scene *scene, const losses *losses, feeler_error *error) {
    scene->dropped_triangles += losses->count;
    if (losses->count == 0)
        return 0;
    bool one = losses->count == 1;
    return scene_warn(scene, losses->place, error, "%zu degenerate %s left out: %s no area", losses->count,
                      one ? "triangle" : "triangles", one ? "it has" : "they have");
}

static int validate_objects(feeler_scene *scene, scene_object *objects, size_t count, feeler_error *error) {
    for (size_t i = 0; i < count; i++) {
        scene_object *object = &objects[i];
        bool own = object->shape == SHAPE_INSTANCE && object->material == -1;
        if (!own && (object->material < 0 || (size_t)object->material >= scene->material_count))
            return bad(object, error, "the object's material is out of range");
        if (object->sides < BOTH_SIDES || object->sides > BACK_ONLY)
            return bad(object, error, "the object's sides are out of range");
        if (validate_shape(scene, object, error) != 0)
            return -1;
    }
    return 0;
}

int scene_validate(feeler_scene *scene, feeler_error *error) {
    losses losses = {0, {NULL, 0, 0}};
    if (validate_camera(&scene->camera, error) != 0 || validate_image(scene, error) != 0)
        return -1;
    for (size_t i = 0; i < scene->light_count; i++)
        if (validate_light(&scene->lights[i], error) != 0)
            return -1;
    for (size_t i = 0; i < scene->material_count; i++)
        if (validate_material(&scene->materials[i], error) != 0)
            return -1;
    for (size_t i = 0; i < scene->group_count; i++) { /* before the instances, which ask for their size */
        scene_group *group = &scene->groups[i];
        if (validate_objects(scene, group->objects, group->object_count, error) != 0)
            return -1;
        drop_all_degenerate(group->objects, &group->object_count, &losses);
        scene_measure_group(group);
    }
    if (validate_objects(scene, scene->objects, scene->object_count, error) != 0)
        return -1;
    drop_all_degenerate(scene->objects, &scene->object_count, &losses);
    return warn_of_losses(scene, &losses, error);
}
