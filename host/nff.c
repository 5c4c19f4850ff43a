/* nff.c - Eric Haines' Neutral File Format: the scenes of the Standard Procedural Databases.
 *
 * A file is a row of entities, each begun by a keyword. Numbers may be spread over lines (cones commonly are); only a
 * light's colour, being optional, has to stand on the light's own line.
 */
#include "nff_fills.h"
#include "nff_text.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TRY(call)                                                                                                      \
    do {                                                                                                               \
        if (call)                                                                                                      \
            return -1;                                                                                                 \
    } while (0)

static const double brightest = 1e6; /* of lights and background, as of every emission */
static const double sharpest = 1e6;  /* greatest shininess */
enum { widest = 65536 };             /* pixels a side */

typedef struct nff_reader {
    nff_text text;
    nff_fills fills;
    feeler_scene *scene;
    feeler_error *error;
    int material; /* of the fill in force; -1: none yet */
    bool has_view;
} nff_reader;

/* An object with the fill in force; NULL after a failure. `at` is where its keyword stands. */
static scene_object *add_object(nff_reader *r, shape shape, place at) {
    if (r->material < 0) {
        fail_at(r->error, FEELER_BAD_INPUT, at, "no fill ('f') comes before this shape");
        return NULL;
    }
    scene_object *object = scene_add_object(r->scene, r->error);
    if (!object)
        return NULL;
    object->shape = shape;
    object->sides = BOTH_SIDES;
    object->material = r->material;
    object->place = at;
    return object;
}

/* ---- viewpoint, background, lights, fills ---- */

enum { FROM, AT, UP, ANGLE, HITHER, RESOLUTION, VIEW_KEYS };

static const char *const view_keys[VIEW_KEYS] = {"from", "at", "up", "angle", "hither", "resolution"};

static int read_view_value(nff_reader *r, int key) {
    scene_camera *camera = &r->scene->camera;
    nff_text *t = &r->text;
    double hither;
    switch (key) {
    case FROM:
        return nff_vector(t, "the eye ('from')", &camera->eye);
    case AT:
        return nff_vector(t, "the point looked at ('at')", &camera->look_at);
    case UP:
        return nff_vector(t, "the upward direction ('up')", &camera->up);
    case ANGLE:
        TRY(nff_number(t, "the angle of view", 0, 180, &camera->fov));
        return camera->fov > 0 && camera->fov < 180 ? 0 : nff_fail(t, "the angle of view should be between 0 and 180");
    case HITHER: /* helps programs with a depth buffer; a ray tracer does not clip */
        return nff_number(t, "the hither distance", -HUGE_VAL, HUGE_VAL, &hither);
    default:
        TRY(nff_whole_number(t, "the picture's width", 1, widest, &r->scene->width));
        return nff_whole_number(t, "the picture's height", 1, widest, &r->scene->height);
    }
}

/* The keys come in any order; all but hither are required. */
static int read_view(nff_reader *r, place at) {
    bool seen[VIEW_KEYS] = {false};
    if (r->has_view)
        return fail_at(r->error, FEELER_BAD_INPUT, at, "a second viewpoint ('v')");
    r->has_view = true;
    r->scene->camera.place = at;
    while (!(seen[FROM] && seen[AT] && seen[UP] && seen[ANGLE] && seen[RESOLUTION])) {
        int key = 0, found = nff_next_word(&r->text);
        if (found < 0)
            return -1;
        while (key < VIEW_KEYS && !(found && nff_word_is(&r->text, view_keys[key])))
            key++;
        if (key == VIEW_KEYS) {
            for (key = 0; key == HITHER || seen[key];)
                key++;
            return nff_fail(&r->text, "the viewpoint needs '%s' here", view_keys[key]);
        }
        if (seen[key])
            return nff_fail(&r->text, "the viewpoint has a second '%s'", view_keys[key]);
        seen[key] = true;
        TRY(read_view_value(r, key));
    }
    return 0;
}

/* hither and friends may also come after the viewpoint's last required key. */
static int read_late_hither(nff_reader *r, place at) {
    if (!r->has_view)
        return fail_at(r->error, FEELER_BAD_INPUT, at, "'hither' belongs to a viewpoint ('v')");
    return read_view_value(r, HITHER);
}

static int read_background(nff_reader *r, place at) {
    (void)at;
    return nff_colour(&r->text, "the background colour", brightest, &r->scene->background);
}

/* A light without colour gets its brightness when their number is known; until then it is marked by a negative one. */
static int read_light(nff_reader *r, place at) {
    vec3 position, colour = {-1, -1, -1};
    TRY(nff_vector(&r->text, "the light's position", &position));
    if (nff_line_goes_on(&r->text))
        TRY(nff_colour(&r->text, "the light's colour", brightest, &colour));
    scene_light *light = scene_add_light(r->scene, r->error);
    if (!light)
        return -1;
    light->directional = false;
    light->position = position;
    light->ambient = (vec3){0, 0, 0};
    light->diffuse = light->specular = colour;
    light->place = at;
    return 0;
}

static void share_light(feeler_scene *scene) {
    double share = 1 / sqrt((double)scene->light_count);
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].diffuse.x < 0)
            scene->lights[i].diffuse = scene->lights[i].specular = (vec3){share, share, share};
}

static int read_fill(nff_reader *r, place at) {
    nff_text *t = &r->text;
    vec3 colour;
    nff_fill fill;
    TRY(nff_colour(t, "the fill's colour", 1, &colour));
    fill.r = colour.x;
    fill.g = colour.y;
    fill.b = colour.z;
    TRY(nff_number(t, "the fill's Kd", 0, 1, &fill.kd));
    TRY(nff_number(t, "the fill's Ks", 0, 1, &fill.ks));
    TRY(nff_number(t, "the fill's Shine", -HUGE_VAL, sharpest, &fill.shine));
    TRY(nff_number(t, "the fill's T", 0, 1, &fill.t));
    TRY(nff_number(t, "the fill's index of refraction", 0, 10, &fill.ior));
    if (fill.ior > 0 && fill.ior < 0.1)
        return nff_fail(t, "the fill's index of refraction should be 0 or from 0.1 to 10, not %g", fill.ior);
    r->material = nff_fills_material(&r->fills, r->scene, &fill, at, r->error);
    return r->material < 0 ? -1 : 0;
}

/* ---- shapes ---- */

static int read_sphere(nff_reader *r, place at) {
    vec3 centre;
    double radius;
    TRY(nff_vector(&r->text, "the sphere's centre", &centre));
    TRY(nff_number(&r->text, "the sphere's radius", -HUGE_VAL, HUGE_VAL, &radius));
    if (radius == 0)
        return nff_fail(&r->text, "the sphere's radius is 0");
    scene_object *object = add_object(r, SHAPE_SPHERE, at);
    if (!object)
        return -1;
    object->sides = radius < 0 ? BACK_ONLY : BOTH_SIDES;
    object->sphere.centre = centre;
    object->sphere.radius = fabs(radius);
    return 0;
}

static int read_cone(nff_reader *r, place at) {
    nff_text *t = &r->text;
    vec3 base, top;
    double base_radius, top_radius;
    TRY(nff_vector(t, "the cone's base point", &base));
    TRY(nff_number(t, "the cone's base radius", -HUGE_VAL, HUGE_VAL, &base_radius));
    TRY(nff_vector(t, "the cone's apex point", &top));
    TRY(nff_number(t, "the cone's apex radius", -HUGE_VAL, HUGE_VAL, &top_radius));
    if (base_radius == 0 && top_radius == 0)
        return nff_fail(t, "both radii of the cone are 0");
    if ((base_radius < 0 && top_radius > 0) || (base_radius > 0 && top_radius < 0))
        return nff_fail(t, "the cone's radii differ in sign");
    if (base.x == top.x && base.y == top.y && base.z == top.z)
        return fail_at(r->error, FEELER_BAD_INPUT, at, "the cone's base and apex are the same point");
    scene_object *object = add_object(r, SHAPE_CONE, at);
    if (!object)
        return -1;
    object->sides = base_radius < 0 || top_radius < 0 ? BACK_ONLY : BOTH_SIDES;
    object->cone.base = base;
    object->cone.top = top;
    object->cone.base_radius = fabs(base_radius);
    object->cone.top_radius = fabs(top_radius);
    object->cone.capped = false;
    return 0;
}

/* A corner takes at least two bytes a number: a greater count is a mistake, found before memory is asked for. */
static int read_corner_count(nff_reader *r, int numbers_per_corner, int *count) {
    TRY(nff_whole_number(&r->text, "the number of corners", 3, INT_MAX, count));
    if ((size_t)*count > (nff_left(&r->text) + 1) / (2 * (size_t)numbers_per_corner))
        return nff_fail(&r->text, "the file ends before %d corners", *count);
    return 0;
}

static int read_polygon(nff_reader *r, place at) {
    int count;
    TRY(read_corner_count(r, 3, &count));
    scene_object *object = add_object(r, count == 3 ? SHAPE_TRIANGLE : SHAPE_POLYGON, at);
    if (!object)
        return -1;
    vec3 *corners = object->triangle.corners;
    if (count > 3) {
        corners = object->polygon.corners = malloc((size_t)count * sizeof *corners);
        object->polygon.count = (size_t)count;
        if (!corners)
            return fail(r->error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    for (int i = 0; i < count; i++)
        TRY(nff_vector(&r->text, "a polygon's corner", &corners[i]));
    return 0;
}

typedef struct nff_corner {
    vec3 point, normal;
} nff_corner;

static int read_patch_corner(nff_reader *r, nff_corner *corner) {
    TRY(nff_vector(&r->text, "a patch's corner", &corner->point));
    TRY(nff_vector(&r->text, "a patch's normal", &corner->normal));
    if (corner->normal.x == 0 && corner->normal.y == 0 && corner->normal.z == 0)
        return nff_fail(&r->text, "a patch's normal has length 0");
    return 0;
}

/* Polygon with normals: a fan of smooth triangles around its first corner. */
static int read_patch(nff_reader *r, place at) {
    int count;
    nff_corner corners[3];
    TRY(read_corner_count(r, 6, &count));
    TRY(read_patch_corner(r, &corners[0]));
    TRY(read_patch_corner(r, &corners[1]));
    for (int i = 2; i < count; i++) {
        TRY(read_patch_corner(r, &corners[2]));
        scene_object *object = add_object(r, SHAPE_TRIANGLE, at);
        if (!object)
            return -1;
        object->triangle.smooth = true;
        for (int k = 0; k < 3; k++) {
            object->triangle.corners[k] = corners[k].point;
            object->triangle.normals[k] = corners[k].normal;
        }
        corners[1] = corners[2];
    }
    return 0;
}

/* ---- the file ---- */

typedef struct nff_entity {
    const char *keyword;
    int (*read)(nff_reader *r, place at);
} nff_entity;

static const nff_entity entities[] = {
    {"v", read_view},    {"b", read_background}, {"l", read_light},
    {"f", read_fill},    {"s", read_sphere},     {"c", read_cone},
    {"p", read_polygon}, {"pp", read_patch},     {"hither", read_late_hither},
};

static int read_entities(nff_reader *r) {
    const size_t count = sizeof entities / sizeof *entities;
    for (;;) {
        size_t i = 0;
        int found = nff_next_word(&r->text);
        if (found <= 0)
            return found;
        while (i < count && !nff_word_is(&r->text, entities[i].keyword))
            i++;
        if (i == count)
            return nff_fail(&r->text, "'%.*s' is not one of v, b, l, f, s, c, p, pp",
                            r->text.length < 40 ? (int)r->text.length : 40, r->text.word);
        TRY(entities[i].read(r, r->text.place));
    }
}

static int read_file(nff_reader *r, const char *path) {
    const char *source = scene_source(r->scene, path, r->error);
    if (!source)
        return -1;
    if (nff_open(&r->text, path, source, r->error) || read_entities(r))
        return -1;
    if (!r->has_view)
        return nff_fail(&r->text, "the file ends without a viewpoint ('v')");
    r->scene->camera.spans_centres = true;
    share_light(r->scene);
    return 0;
}

feeler_scene *scene_read_nff(const char *path, feeler_error *error) {
    nff_reader r = {.error = error, .material = -1, .scene = scene_new(error)};
    if (!r.scene)
        return NULL;
    int status = read_file(&r, path);
    nff_close(&r.text);
    nff_fills_clear(&r.fills);
    if (status) {
        feeler_scene_free(r.scene);
        return NULL;
    }
    return r.scene;
}
