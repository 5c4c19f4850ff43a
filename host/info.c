/* info.c - what a scene contains and what it makes of the kernels, as JSON. */
#include "packed.h"
#include "program.h"
#include "tuned.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static json_t *primitives_json(const packed *p) {
    static const packed_array kinds[] = {ARRAY_SPHERES,   ARRAY_PLANES,   ARRAY_DISCS, ARRAY_BOXES,
                                         ARRAY_TRIANGLES, ARRAY_POLYGONS, ARRAY_CONES, ARRAY_INSTANCES};
    json_t *json = json_object();
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (p->arrays[kinds[i]].count)
            json_object_set_new(json, p->arrays[kinds[i]].name, json_integer((json_int_t)p->arrays[kinds[i]].count));
    return json;
}

static json_t *memory_json(const packed *p) {
    json_t *json = json_object();
    size_t total = 0;
    for (int i = 0; i < ARRAY_COUNT; i++) {
        const array *a = &p->arrays[i];
        size_t bytes = a->count * a->element / (a->is_real && !p->is_double ? 2 : 1);
        if (bytes)
            json_object_set_new(json, a->name, json_integer((json_int_t)bytes));
        total += bytes;
    }
    json_object_set_new(json, "total", json_integer((json_int_t)total));
    return json;
}

static json_t *features_json(uint32_t features) {
    json_t *json = json_array();
    for (int i = 0; i < FEATURE_COUNT; i++)
        if (features >> i & 1)
            json_array_append_new(json, json_string(feature_names[i]));
    return json;
}

static json_t *warnings_json(const feeler_scene *scene) {
    json_t *json = json_array();
    for (size_t i = 0; i < scene->warning_count; i++)
        json_array_append_new(json, json_string(scene->warnings[i]));
    return json;
}

static json_t *info_json(const feeler_scene *scene, const feeler_settings *s, const packed *p, needs n,
                         const char *options) {
    static const char *const levels[] = {"draft", "standard", "reference"};
    json_t *json = json_object();
    json_object_set_new(json, "name", json_string(scene->name ? scene->name : ""));
    json_object_set_new(json, "objects", json_integer((json_int_t)scene->object_count));
    json_object_set_new(json, "primitives", primitives_json(p));
    json_object_set_new(json, "materials", json_integer((json_int_t)scene->material_count));
    json_object_set_new(json, "lights", json_integer((json_int_t)scene->light_count));
    json_object_set_new(json, "size", json_pack("[i, i]", s->width, s->height));
    json_object_set_new(json, "samples", json_integer(s->samples));
    json_object_set_new(json, "depth", json_integer(s->depth));
    json_object_set_new(json, "cutoff", json_real(s->cutoff));
    json_object_set_new(json, "level", json_string(levels[s->level]));
    json_object_set_new(json, "features", features_json(n.features));
    json_object_set_new(json, "options", json_string(options));
    json_object_set_new(json, "tuned", tuned_json(options));
    json_object_set_new(json, "tree_nodes", json_integer((json_int_t)p->arrays[ARRAY_NODES].count));
    json_object_set_new(json, "memory_bytes", memory_json(p));
    json_object_set_new(json, "seconds",
                        json_pack("{s: f, s: f}", "load", scene->load_seconds, "tree", p->tree_seconds));
    json_object_set_new(json, "warnings", warnings_json(scene));
    return json;
}

char *feeler_scene_info_json(const feeler_scene *scene, const feeler_settings *settings, feeler_error *error) {
    feeler_settings s;
    packed p;
    if (resolve_settings(scene, settings, &s, error) < 0)
        return NULL;
    const needs n = choose_needs(scene, &s);
    if (pack_scene(&p, scene, &s, n, error) < 0)
        return NULL;
    char *text = NULL, *options = program_options(&s, n, error);
    if (options) {
        json_t *json = info_json(scene, &s, &p, n, options);
        text = json ? json_dumps(json, JSON_INDENT(2)) : NULL;
        json_decref(json);
        if (!text)
            fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    free(options);
    packed_free(&p);
    return text;
}
