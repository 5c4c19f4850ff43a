/* scene.c - the life of a scene: made with defaults, appended to, loaded by its file's ending, freed. */
#include "scene.h"
#include "clock.h"
#include "schema.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

feeler_scene *scene_new(feeler_error *error) {
    feeler_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
        return NULL;
    }
    schema_set_defaults(scene_keys, scene);
    schema_set_defaults(camera_keys, &scene->camera);
    schema_set_defaults(image_keys, scene);
    scene->width = 640;
    scene->height = 480;
    return scene;
}

void *grow(void *items, size_t count, size_t *capacity, size_t item_size, feeler_error *error) {
    if (count < *capacity)
        return items;
    size_t wanted = *capacity ? *capacity * 2 : 16;
    void *moved = wanted > SIZE_MAX / item_size ? NULL : realloc(items, wanted * item_size);
    if (!moved) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
        return NULL;
    }
    *capacity = wanted;
    return moved;
}

scene_object *scene_add_object(feeler_scene *scene, feeler_error *error) {
    scene_object *items = grow(scene->objects, scene->object_count, &scene->object_capacity, sizeof *items, error);
    if (!items)
        return NULL;
    scene->objects = items;
    scene_object *object = &items[scene->object_count++];
    memset(object, 0, sizeof *object);
    object->number = (int)scene->object_count - 1;
    return object;
}

scene_group *scene_add_group(feeler_scene *scene, feeler_error *error) {
    scene_group *items = grow(scene->groups, scene->group_count, &scene->group_capacity, sizeof *items, error);
    if (!items)
        return NULL;
    scene->groups = items;
    scene_group *group = &items[scene->group_count++];
    memset(group, 0, sizeof *group);
    return group;
}

scene_light *scene_add_light(feeler_scene *scene, feeler_error *error) {
    scene_light *items = grow(scene->lights, scene->light_count, &scene->light_capacity, sizeof *items, error);
    if (!items)
        return NULL;
    scene->lights = items;
    scene_light *light = &items[scene->light_count++];
    memset(light, 0, sizeof *light);
    return light;
}

scene_material *scene_add_material(feeler_scene *scene, feeler_error *error) {
    scene_material *items =
        grow(scene->materials, scene->material_count, &scene->material_capacity, sizeof *items, error);
    if (!items)
        return NULL;
    scene->materials = items;
    scene_material *material = &items[scene->material_count++];
    memset(material, 0, sizeof *material);
    schema_set_defaults(material_keys, material);
    return material;
}

static const char *add_text(char ***texts, size_t *count, size_t *capacity, const char *text, feeler_error *error) {
    char **items = grow(*texts, *count, capacity, sizeof *items, error);
    if (!items)
        return NULL;
    *texts = items;
    char *copy = strdup(text);
    if (!copy) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
        return NULL;
    }
    items[(*count)++] = copy;
    return copy;
}

const char *scene_source(feeler_scene *scene, const char *name, feeler_error *error) {
    for (size_t i = 0; i < scene->source_count; i++)
        if (strcmp(scene->sources[i], name) == 0)
            return scene->sources[i];
    return scene_add_source(scene, name, error);
}

const char *scene_add_source(feeler_scene *scene, const char *name, feeler_error *error) {
    return add_text(&scene->sources, &scene->source_count, &scene->source_capacity, name, error);
}

int scene_warn(feeler_scene *scene, place place, feeler_error *error, const char *format, ...) {
    char text[1024], whole[sizeof text + 600];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (place.source && place.line > 0)
        snprintf(whole, sizeof whole, "%.500s:%d:%d: %s", place.source, place.line, place.column, text);
    else
        snprintf(whole, sizeof whole, "%.500s%s%s", place.source ? place.source : "", place.source ? ": " : "", text);
    return add_text(&scene->warnings, &scene->warning_count, &scene->warning_capacity, whole, error) ? 0 : -1;
}

const char *feeler_scene_warning(const feeler_scene *scene, int index) {
    return index >= 0 && (size_t)index < scene->warning_count ? scene->warnings[index] : NULL;
}

void scene_object_clear(scene_object *object) {
    if (object->shape == SHAPE_POLYGON) {
        free(object->polygon.corners);
    } else if (object->shape == SHAPE_MESH) {
        free(object->mesh.vertices);
        free(object->mesh.normals);
        free(object->mesh.indices);
    }
    memset(object, 0, sizeof *object);
}

void feeler_scene_free(feeler_scene *scene) {
    if (!scene)
        return;
    for (size_t i = 0; i < scene->object_count; i++)
        scene_object_clear(&scene->objects[i]);
    for (size_t i = 0; i < scene->group_count; i++) {
        for (size_t k = 0; k < scene->groups[i].object_count; k++)
            scene_object_clear(&scene->groups[i].objects[k]);
        free(scene->groups[i].objects);
    }
    for (size_t i = 0; i < scene->material_count; i++)
        free(scene->materials[i].name);
    for (size_t i = 0; i < scene->warning_count; i++)
        free(scene->warnings[i]);
    for (size_t i = 0; i < scene->source_count; i++)
        free(scene->sources[i]);
    free(scene->objects);
    free(scene->groups);
    free(scene->materials);
    free(scene->lights);
    free(scene->warnings);
    free(scene->sources);
    free(scene->name);
    free(scene);
}

/* The file's name without its folder and ending, to be freed. */
static char *bare_name(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    return strndup(name, dot && dot != name ? (size_t)(dot - name) : strlen(name));
}

/* Readers differ in what they say of a file that is not there; this says it once, for all. */
static int check_file(const char *path, feeler_error *error) {
    struct stat status;
    place file = {path, 0, 0};
    if (stat(path, &status) != 0)
        return fail_at(error, FEELER_IO, file, "cannot be opened: %s", strerror(errno));
    if (S_ISDIR(status.st_mode))
        return fail_at(error, FEELER_IO, file, "is a folder, not a scene");
    return 0;
}

static feeler_scene *read_by_ending(const char *path, feeler_error *error) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    if (!dot || !dot[1]) {
        fail_at(error, FEELER_BAD_INPUT, (place){path, 0, 0},
                "has no ending that tells its format (.yaml, .nff, .obj, .ply, …)");
        return NULL;
    }
    if (strcasecmp(dot, ".yaml") == 0 || strcasecmp(dot, ".yml") == 0)
        return scene_read_yaml(path, error);
    if (strcasecmp(dot, ".nff") == 0)
        return scene_read_nff(path, error);
    return scene_read_mesh(path, error);
}

feeler_scene *feeler_scene_load(const char *path, feeler_error *error) {
    double start = seconds_now();
    if (check_file(path, error) != 0)
        return NULL;
    feeler_scene *scene = read_by_ending(path, error);
    if (!scene)
        return NULL;
    free(scene->name);
    scene->name = bare_name(path);
    if (!scene->name)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    if (!scene->name || scene_validate(scene, error) != 0) {
        feeler_scene_free(scene);
        return NULL;
    }
    scene->load_seconds = seconds_now() - start;
    return scene;
}
