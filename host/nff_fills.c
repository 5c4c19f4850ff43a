/* nff_fills.c - NFF fills as materials of the model, each distinct fill once. */
#include "nff_fills.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct nff_known_fill {
    nff_fill fill;
    int material; /* -1: the slot is free */
} nff_known_fill;

static bool equal(const nff_fill *a, const nff_fill *b) {
    return a->r == b->r && a->g == b->g && a->b == b->b && a->kd == b->kd && a->ks == b->ks && a->shine == b->shine &&
           a->t == b->t && a->ior == b->ior;
}

static uint64_t mix(uint64_t hash, double value) {
    uint64_t bits;
    value += 0.0; /* -0 equals 0 and has to hash like it */
    memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ (hash >> 32);
}

static uint64_t hash_of(const nff_fill *f) {
    uint64_t hash = 0;
    hash = mix(mix(mix(hash, f->r), f->g), f->b);
    hash = mix(mix(hash, f->kd), f->ks);
    return mix(mix(mix(hash, f->shine), f->t), f->ior);
}

/* The slot that holds an equal fill, or the free one where it belongs. The table is never full. */
static nff_known_fill *slot_of(const nff_fills *fills, const nff_fill *fill) {
    size_t i = hash_of(fill) & (fills->capacity - 1);
    while (fills->known[i].material >= 0 && !equal(&fills->known[i].fill, fill))
        i = (i + 1) & (fills->capacity - 1);
    return &fills->known[i];
}

/* Keeps at least half of the slots free. */
static int make_room(nff_fills *fills, feeler_error *error) {
    if (fills->count * 2 < fills->capacity)
        return 0;
    nff_fills bigger = {.capacity = fills->capacity ? fills->capacity * 2 : 64, .count = fills->count};
    bigger.known = malloc(bigger.capacity * sizeof *bigger.known);
    if (!bigger.known)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < bigger.capacity; i++)
        bigger.known[i].material = -1;
    for (size_t i = 0; i < fills->capacity; i++)
        if (fills->known[i].material >= 0)
            *slot_of(&bigger, &fills->known[i].fill) = fills->known[i];
    free(fills->known);
    *fills = bigger;
    return 0;
}

/* What NFF leaves open: Ks is both the white highlight c_s and rho_rg, T is rho_tg; c_a, c_td, c_ts and I_e are 0. */
static void fill_material(scene_material *m, const nff_fill *f, place place) {
    bool highlight = f->shine > 0;
    double specular = highlight ? f->ks : 0;
    m->ambient = m->diffuse_transmission = m->specular_transmission = m->emission = (vec3){0, 0, 0};
    m->diffuse = (vec3){f->kd * f->r, f->kd * f->g, f->kd * f->b};
    m->specular = (vec3){specular, specular, specular};
    m->reflection = (vec3){f->ks, f->ks, f->ks};
    m->transmission = (vec3){f->t, f->t, f->t};
    m->shininess = highlight ? f->shine : 1;
    m->ior = f->ior == 0 ? 1 : f->ior;
    m->place = place;
}

int nff_fills_material(nff_fills *fills, feeler_scene *scene, const nff_fill *fill, place place, feeler_error *error) {
    if (make_room(fills, error))
        return -1;
    nff_known_fill *slot = slot_of(fills, fill);
    if (slot->material >= 0)
        return slot->material;
    if (scene->material_count >= INT_MAX)
        return fail_at(error, FEELER_BAD_INPUT, place, "too many materials");
    scene_material *material = scene_add_material(scene, error);
    if (!material)
        return -1;
    fill_material(material, fill, place);
    slot->fill = *fill;
    slot->material = (int)(scene->material_count - 1);
    fills->count++;
    return slot->material;
}

void nff_fills_clear(nff_fills *fills) {
    free(fills->known);
    *fills = (nff_fills){0};
}
