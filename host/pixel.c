/* pixel.c - the ray tree of a pixel as JSON, from the notes that the kernels take of it. */
#include "pixel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

json_t *text_json(const char *text) {
    char plain[1024];
    json_t *json = json_string(text);
    if (json)
        return json;
    snprintf(plain, sizeof plain, "%s", text);
    for (char *c = plain; *c; c++)
        *c = (unsigned char)*c < 0x80 ? *c : '?';
    return json_string(plain);
}

static int index_notes(story *t, feeler_error *error) {
    const notes *n = t->notes;
    uint32_t **arrays[] = {&t->first_light, &t->first_crossing, &t->children[0], &t->children[1]};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        if (!(*arrays[i] = malloc(((size_t)n->count.x + 1) * sizeof **arrays[i])))
            return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    t->starts = calloc(t->scene->group_count + 1, sizeof *t->starts);
    if (!t->starts)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (uint32_t ray = 0, light = 0, crossing = 0; ray <= n->count.x; ray++) {
        while (light < n->count.y && n->light_tags[light].at.x < ray)
            light++;
        while (crossing < n->count.z && n->crossing_tags[crossing].at.x < ray)
            crossing++;
        t->first_light[ray] = light;
        t->first_crossing[ray] = crossing;
        t->children[0][ray] = t->children[1][ray] = NOT_NOTED;
        if (ray < n->count.x && n->ray_tags[ray].sent.x != NOT_NOTED)
            t->children[n->ray_tags[ray].sent.z == RAY_REFLECTION ? 0 : 1][n->ray_tags[ray].sent.x] = ray;
    }
    return 0;
}

static void story_free(story *t) {
    free(t->first_light);
    free(t->first_crossing);
    free(t->children[0]);
    free(t->children[1]);
    for (size_t i = 0; t->starts && i <= t->scene->group_count; i++)
        free(t->starts[i]);
    free(t->starts);
}

static json_t *scene_lights_json(const feeler_scene *scene) {
    json_t *list = json_array();
    for (size_t i = 0; i < scene->light_count; i++) {
        const scene_light *l = &scene->lights[i];
        json_array_append_new(
            list, json_pack("{s: s, s: o, s: o, s: o, s: o}", "kind", l->directional ? "directional" : "point",
                            l->directional ? "direction" : "position", vec_json(l->position), "diffuse",
                            vec_json(l->diffuse), "specular", vec_json(l->specular), "place", place_json(l->place)));
    }
    return list;
}

static json_t *pixel_json(const story *t, feeler_error *error) {
    static const char *const levels[] = {"draft", "standard", "reference"};
    const feeler_settings *s = &t->job->settings;
    const notes *n = t->notes;
    json_t *trees = trees_json(t, error), *parts = trees ? parts_json(t, error) : NULL;
    if (!parts) {
        json_decref(trees);
        return NULL;
    }
    json_t *json = json_pack("{s: o, s: s, s: [i, i], s: [i, i], s: i, s: f, s: i, s: f, s: s}", "scene",
                             text_json(t->scene->name ? t->scene->name : ""), "device", t->job->device->name, "size",
                             s->width, s->height, "pixel", s->region[0], s->region[1], "samples", s->samples, "jitter",
                             s->jitter, "depth", s->depth, "cutoff", s->cutoff, "level", levels[s->level]);
    json_object_set_new(json, "sample", t->sample < 0 ? json_null() : json_integer(t->sample));
    json_object_set_new(json, "colour", colour_json(n->pixel));
    json_object_set_new(json, "alpha", json_real(n->pixel.w));
    json_object_set_new(json, "discarded_weight", colour_json(n->unsent));
    json_object_set_new(json, "rays",
                        json_pack("{s: i, s: I, s: I, s: I}", "eye", s->samples, "reflection", (json_int_t)n->sent.x,
                                  "transmission", (json_int_t)n->sent.y, "shadow", (json_int_t)n->sent.z));
    json_object_set_new(json, "lights", scene_lights_json(t->scene));
    json_object_set_new(json, "ambient", colour_json(pack_view(t->scene, s, t->job->packed.origin).ambient));
    json_object_set_new(json, "background", vec_json(t->scene->background));
    json_object_set_new(json, "made_of", parts);
    json_object_set_new(json, "trees", trees);
    json_object_set_new(json, "words", words_json(json));
    return json;
}

static char *pixel_text(const story *t, feeler_error *error) {
    /* As many digits as tell a float; a scene that was moved has points that are none. */
    const bool is_float = real_size(t->job) == sizeof(float) && vec_extent(t->job->packed.origin) == 0;
    json_t *json = pixel_json(t, error);
    char *text = json ? json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(is_float ? 9 : 17)) : NULL;
    json_decref(json);
    if (!text)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the rays of a pixel");
    return text;
}

static int settle(job *j, const feeler_scene *scene, const feeler_settings *asked, int x, int y, int sample,
                  feeler_error *error) {
    feeler_settings one = *asked;
    one.lanes = one.pixels[0] = one.pixels[1] = one.work_group[0] = one.work_group[1] = 1;
    memset(one.region, 0, sizeof one.region);
    if (resolve_settings(scene, &one, &j->settings, error) < 0)
        return -1;
    const feeler_settings *s = &j->settings;
    if (x < 0 || y < 0 || x >= s->width || y >= s->height)
        return fail(error, FEELER_BAD_USAGE, "the pixel %d,%d is not in the picture of %d x %d pixels", x, y, s->width,
                    s->height);
    if (sample >= s->samples)
        return fail(error, FEELER_BAD_USAGE, "there is no sample %d: the pixel has %d, from 0 on", sample, s->samples);
    memcpy(j->settings.region, (int[4]){x, y, x + 1, y + 1}, sizeof j->settings.region);
    return 0;
}

char *feeler_pixel_json(const feeler_scene *scene, const feeler_settings *settings, feeler_device *device, int x, int y,
                        int sample, feeler_error *error) {
    job j = {.device = device, .notes = true};
    notes n = {0};
    story t = {.scene = scene, .job = &j, .notes = &n, .sample = sample};
    char *text = NULL;
    if (settle(&j, scene, settings, x, y, sample, error) == 0 && open_job(&j, scene, NULL, NULL, error) == 0 &&
        take_notes(&j, &n, error) == 0 && index_notes(&t, error) == 0)
        text = pixel_text(&t, error);
    story_free(&t);
    notes_free(&n);
    close_job(&j);
    return text;
}
