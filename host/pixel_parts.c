/* pixel_parts.c - what a pixel's colour is made of: weight times each term of each ray, added up by what they are of. */
#include "pixel.h"

#include <stdlib.h>

enum { AMBIENT, EMISSION, DIFFUSE, SPECULAR, DIFFUSE_TRANSMISSION, SPECULAR_TRANSMISSION, BACKGROUND };

static const char *const terms[] = {
    "ambient", "emission", "diffuse", "specular", "diffuse_transmission", "specular_transmission", "background"};

/* One with the same key as another is of the same thing. */
typedef struct part {
    struct {
        size_t term, light, kind, level, object, inside;
    } key;
    origin origin;
    uint32_t material;
    vec3 colour;
    size_t rays;
} part;

typedef struct parts {
    part *list; /* owned */
    size_t count, capacity;
} parts;

static double brightness(const part *p) {
    return p->colour.x + p->colour.y + p->colour.z;
}

/* The sum is the mean of the samples. */
static int add_part(const story *t, parts *all, uint32_t ray, size_t term, size_t light, vec3 colour,
                    feeler_error *error) {
    const ray_tags *tags = &t->notes->ray_tags[ray];
    const vec3 weight = term == BACKGROUND ? (vec3){1, 1, 1} : xyz(t->notes->rays[ray].weight);
    const double samples = t->sample < 0 ? t->job->settings.samples : 1;
    if (all->count == all->capacity) {
        size_t capacity = all->capacity ? 2 * all->capacity : 64;
        part *list = realloc(all->list, capacity * sizeof *list);
        if (!list)
            return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the rays of a pixel");
        all->list = list;
        all->capacity = capacity;
    }
    part *p = &all->list[all->count];
    *p = (part){.key = {.term = term, .light = light, .kind = tags->sent.z, .level = tags->sent.w},
                .material = tags->met.z,
                .colour = vec_scale(vec_multiply(colour, weight), 1 / samples),
                .rays = 1};
    if (brightness(p) == 0)
        return 0;
    all->count++;
    if (term == BACKGROUND)
        return 0;
    int status = find_origin(t, tags->met, &p->origin, error);
    p->key.object = p->origin.number;
    p->key.inside = p->origin.inside_number;
    return status;
}

static int add_light(const story *t, parts *all, uint32_t ray, uint32_t index, feeler_error *error) {
    const uint4 at = t->notes->light_tags[index].at;
    const bool back = at.z == LIGHT_BACK;
    vec3 diffuse, specular;
    find_terms(t, index, &diffuse, &specular);
    if (add_part(t, all, ray, back ? DIFFUSE_TRANSMISSION : DIFFUSE, at.y, diffuse, error) < 0)
        return -1;
    return add_part(t, all, ray, back ? SPECULAR_TRANSMISSION : SPECULAR, at.y, specular, error);
}

static int add_ray(const story *t, parts *all, uint32_t ray, feeler_error *error) {
    const ray_note *r = &t->notes->rays[ray];
    if (t->notes->ray_tags[ray].met.x == NOT_NOTED)
        return add_part(t, all, ray, BACKGROUND, 0, xyz(r->background), error);
    if (add_part(t, all, ray, AMBIENT, 0, xyz(r->ambient), error) < 0 ||
        add_part(t, all, ray, EMISSION, 0, xyz(r->emission), error) < 0)
        return -1;
    for (uint32_t i = t->first_light[ray]; i < t->first_light[ray + 1]; i++)
        if (add_light(t, all, ray, i, error) < 0)
            return -1;
    return 0;
}

static int compare_keys(const void *left, const void *right) {
    const part *a = left, *b = right;
    const size_t keys[][2] = {{a->key.term, b->key.term},     {a->key.light, b->key.light},
                              {a->key.kind, b->key.kind},     {a->key.level, b->key.level},
                              {a->key.object, b->key.object}, {a->key.inside, b->key.inside}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (keys[i][0] != keys[i][1])
            return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

/* The brightest first; what is as bright stays in a known order. */
static int compare_brightness(const void *left, const void *right) {
    const double a = brightness(left), b = brightness(right);
    return a != b ? (a < b) - (a > b) : compare_keys(left, right);
}

static void join_alike(parts *all) {
    size_t kept = 0;
    if (all->count == 0)
        return;
    qsort(all->list, all->count, sizeof *all->list, compare_keys);
    for (size_t i = 1; i < all->count; i++) {
        part *p = &all->list[kept];
        if (compare_keys(p, &all->list[i]) != 0) {
            all->list[++kept] = all->list[i];
            continue;
        }
        p->colour = vec_add(p->colour, all->list[i].colour);
        p->rays++;
    }
    all->count = kept + 1;
    qsort(all->list, all->count, sizeof *all->list, compare_brightness);
}

static json_t *part_json(const story *t, const part *p, double whole) {
    static const char *const kinds[] = {"eye", "reflection", "transmission"};
    const bool lit = p->key.term >= DIFFUSE && p->key.term <= SPECULAR_TRANSMISSION;
    json_t *json = json_pack("{s: s, s: s, s: i, s: I, s: f, s: [f, f, f]}", "term", terms[p->key.term], "ray",
                             kinds[p->key.kind], "level", (int)p->key.level, "rays", (json_int_t)p->rays, "share",
                             brightness(p) / whole, "colour", p->colour.x, p->colour.y, p->colour.z);
    if (lit)
        json_object_set_new(json, "light", json_integer((json_int_t)p->key.light));
    if (p->key.term != BACKGROUND) {
        json_object_set_new(json, "object", origin_json(&p->origin));
        json_object_set_new(json, "material", material_json(t, p->material));
    }
    return json;
}

json_t *parts_json(const story *t, feeler_error *error) {
    parts all = {0};
    int status = 0;
    for (uint32_t ray = 0; status == 0 && ray < t->notes->count.x; ray++)
        if (t->sample < 0 || t->notes->ray_tags[ray].sent.y == (uint32_t)t->sample)
            status = add_ray(t, &all, ray, error);
    json_t *json = NULL;
    if (status == 0) {
        double whole = 0;
        join_alike(&all);
        for (size_t i = 0; i < all.count; i++)
            whole += brightness(&all.list[i]);
        json = json_array();
        for (size_t i = 0; i < all.count; i++)
            json_array_append_new(json, part_json(t, &all.list[i], whole));
    }
    free(all.list);
    return json;
}
