/* pixel_rays.c - rays, what they meet, and the lights and feelers there, as JSON from the notes of them. */
#include "pixel.h"

#include <stdio.h>

json_t *vec_json(vec3 v) {
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

json_t *colour_json(real4 v) {
    return vec_json(xyz(v));
}

/* A point of the packed scene in the scene's own coordinates. */
static json_t *point_json(const story *t, real4 v) {
    return vec_json(vec_add(xyz(v), t->job->packed.origin));
}

static json_t *length_json(double length) {
    return isfinite(length) ? json_real(length) : json_null();
}

json_t *material_json(const story *t, uint32_t index) {
    char number[32];
    const char *name = t->scene->materials[index].name;
    snprintf(number, sizeof number, "materials[%u]", (unsigned)index);
    return text_json(name && *name ? name : number);
}

/* Names, outermost first. */
static json_t *media_json(const story *t, uint4 outer, uint4 inner) {
    const uint32_t list[MOST_MEDIA] = {outer.x, outer.y, outer.z, outer.w, inner.x, inner.y, inner.z, inner.w};
    json_t *json = json_array();
    for (int i = 0; i < MOST_MEDIA; i++)
        if (list[i] != NOT_NOTED)
            json_array_append_new(json, material_json(t, list[i]));
    return json;
}

/* ---- what is on the way ---- */

static int add_crossing(const story *t, uint32_t index, json_t *list, feeler_error *error) {
    const crossing_note *c = &t->notes->crossings[index];
    const crossing_tags *tags = &t->notes->crossing_tags[index];
    origin o;
    if (find_origin(t, tags->met, &o, error) < 0)
        return -1;
    json_t *json = json_pack("{s: o, s: o, s: f}", "object", origin_json(&o), "material", material_json(t, tags->met.z),
                             "distance", c->share.w);
    if (tags->at.z == CROSSING_FILTER)
        json_object_set_new(json, "share", colour_json(c->share));
    if (tags->at.z == CROSSING_HIDDEN || tags->at.z == CROSSING_TOUCHING)
        json_object_set_new(json, "entering", json_boolean(tags->met.w & NOTED_ENTERING));
    json_array_append_new(list, json);
    return 0;
}

/* Those of one kind on a ray's way (`light` is NOT_NOTED) or on that of a feeler. NULL: out of memory. */
static json_t *crossings_json(const story *t, uint32_t ray, uint32_t light, uint32_t kind, feeler_error *error) {
    json_t *list = json_array();
    for (uint32_t i = t->first_crossing[ray]; i < t->first_crossing[ray + 1]; i++) {
        const uint4 at = t->notes->crossing_tags[i].at;
        if (at.y == light && at.z == kind && add_crossing(t, i, list, error) < 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

/* ---- lights ---- */

/* Why no feeler is sent to a light whose terms cannot contribute. */
static const char *why_no_feeler(const story *t, const light_note *l, const light_tags *tags, const scene_material *m,
                                 bool refracts) {
    if (!t->scene->shadows && tags->at.w & NOTED_COUNTS)
        return "no shadows";
    const scene_light *light = &t->scene->lights[tags->at.y];
    if (is_black(light->diffuse) && is_black(light->specular))
        return "black light";
    if (vec_extent(xyz(l->direction)) == 0)
        return "at the light";
    if (tags->at.z == LIGHT_NEITHER)
        return "grazing";
    const bool back = tags->at.z == LIGHT_BACK;
    const vec3 diffuse = back ? m->diffuse_transmission : m->diffuse,
               specular = back ? m->specular_transmission : m->specular;
    if (is_black(diffuse) && is_black(specular))
        return back ? "behind" : "coefficients";
    if (back && !refracts && is_black(diffuse))
        return "total reflection";
    if (!is_black(xyz(l->specular)) && l->share.w <= 0)
        return "outside the highlight";
    return "no common term";
}

void find_terms(const story *t, uint32_t index, vec3 *diffuse, vec3 *specular) {
    const light_note *l = &t->notes->lights[index];
    const bool counts = t->notes->light_tags[index].at.w & NOTED_COUNTS;
    const vec3 share = counts ? xyz(l->share) : (vec3){0, 0, 0};
    *diffuse = vec_scale(vec_multiply(xyz(l->diffuse), share), fabs(l->diffuse.w));
    *specular = vec_scale(vec_multiply(xyz(l->specular), share), l->specular.w);
}

static json_t *feeler_json(const story *t, uint32_t ray, uint32_t index, feeler_error *error) {
    const light_note *l = &t->notes->lights[index];
    const bool near = !t->scene->lights[t->notes->light_tags[index].at.y].directional;
    json_t *crossed = crossings_json(t, ray, index, CROSSING_FILTER, error);
    json_t *blockers = crossed ? crossings_json(t, ray, index, CROSSING_BLOCKER, error) : NULL;
    if (!blockers) {
        json_decref(crossed);
        return NULL;
    }
    /* What a filtered feeler crosses last may be what ends it. */
    size_t last = json_array_size(crossed);
    if (last && is_black(xyz(l->share)))
        json_array_append(blockers, json_array_get(crossed, last - 1));
    json_t *blocker = json_array_size(blockers) ? json_incref(json_array_get(blockers, 0)) : json_null();
    json_decref(blockers);
    return json_pack("{s: o, s: o, s: o, s: o, s: o, s: o}", "origin", point_json(t, l->feeler_origin), "direction",
                     colour_json(l->feeler), "length", length_json(near ? l->feeler.w : INFINITY), "share",
                     colour_json(l->share), "crossed", crossed, "blocked_by", blocker);
}

static json_t *light_json(const story *t, uint32_t ray, uint32_t index, feeler_error *error) {
    static const char *const sides[] = {"neither", "front", "back"};
    const light_note *l = &t->notes->lights[index];
    const light_tags *tags = &t->notes->light_tags[index];
    const uint4 met = t->notes->ray_tags[ray].met;
    const bool back = tags->at.z == LIGHT_BACK, near = !t->scene->lights[tags->at.y].directional;
    json_t *feeler = json_null();
    if (tags->at.w & NOTED_FEELER && !(feeler = feeler_json(t, ray, index, error)))
        return NULL;
    vec3 diffuse, specular;
    find_terms(t, index, &diffuse, &specular);
    json_t *json = json_pack("{s: i, s: s, s: o, s: o, s: f, s: f, s: o, s: o, s: o, s: o}", "light", (int)tags->at.y,
                             "side", sides[tags->at.z], "direction", colour_json(l->direction), "distance",
                             length_json(near ? l->direction.w : INFINITY), "cosine", l->diffuse.w, "highlight",
                             l->specular.w, back ? "diffuse_transmission" : "diffuse", vec_json(diffuse),
                             back ? "specular_transmission" : "specular", vec_json(specular), "colour",
                             colour_json(l->colour), "feeler", feeler);
    if (!(tags->at.w & NOTED_FEELER))
        json_object_set_new(
            json, "no_feeler",
            json_string(why_no_feeler(t, l, tags, &t->scene->materials[met.z], met.w & NOTED_REFRACTS)));
    return json;
}

static json_t *lights_json(const story *t, uint32_t ray, feeler_error *error) {
    json_t *list = json_array();
    for (uint32_t i = t->first_light[ray]; i < t->first_light[ray + 1]; i++) {
        json_t *light = light_json(t, ray, i, error);
        if (!light) {
            json_decref(list);
            return NULL;
        }
        json_array_append_new(list, light);
    }
    return list;
}

/* ---- rays ---- */

static json_t *ray_json(const story *t, uint32_t ray, vec3 *colour, feeler_error *error);

enum { REFLECTION, TRANSMISSION };

/* Why a ray was not sent on. */
static const char *why_unsent(const story *t, uint32_t ray, int which, vec3 share, vec3 weight) {
    const ray_tags *tags = &t->notes->ray_tags[ray];
    const scene_material *m = &t->scene->materials[tags->met.z];
    if (which == TRANSMISSION && !(tags->met.w & NOTED_REFRACTS) && !is_black(m->transmission))
        return "total reflection";
    if (is_black(share))
        return "coefficients";
    if (is_black(weight))
        return "weight";
    return (int)tags->sent.w >= t->job->settings.depth ? "depth" : "cutoff";
}

/* What is sent on one way, or not; adds what comes back to the colour. */
static json_t *child_json(const story *t, uint32_t ray, int which, vec3 *colour, feeler_error *error) {
    const ray_note *r = &t->notes->rays[ray];
    const uint32_t flag = which == REFLECTION ? NOTED_REFLECTION : NOTED_TRANSMISSION;
    const vec3 share = xyz(which == REFLECTION ? r->reflection_share : r->transmission_share);
    const vec3 weight = xyz(which == REFLECTION ? r->reflection : r->transmission);
    const bool sent = t->notes->ray_tags[ray].met.w & flag;
    const uint32_t child = t->children[which][ray];
    json_t *json = json_pack("{s: o, s: o, s: b}", "share", vec_json(share), "weight", vec_json(weight), "sent", sent);
    if (!sent) {
        json_object_set_new(json, "unsent", json_string(why_unsent(t, ray, which, share, weight)));
        return json;
    }
    vec3 back = {0, 0, 0};
    json_t *next = child == NOT_NOTED ? json_null() : ray_json(t, child, &back, error);
    if (!next) {
        json_decref(json);
        return NULL;
    }
    *colour = vec_add(*colour, vec_multiply(share, back));
    json_object_set_new(json, "ray", next);
    return json;
}

/* Whether anything asks for the refractive indices at a hit. */
static bool asks_for_indices(const scene_material *m) {
    return !is_black(m->transmission) || !is_black(m->specular_transmission);
}

static int add_hit(const story *t, uint32_t ray, json_t *json, feeler_error *error) {
    const ray_note *r = &t->notes->rays[ray];
    const ray_tags *tags = &t->notes->ray_tags[ray];
    const scene_material *m = &t->scene->materials[tags->met.z];
    origin o;
    json_t *touching = crossings_json(t, ray, NOT_NOTED, CROSSING_TOUCHING, error);
    json_t *lights = touching ? lights_json(t, ray, error) : NULL;
    if (!lights || find_origin(t, tags->met, &o, error) < 0) {
        json_decref(touching);
        json_decref(lights);
        return -1;
    }
    const bool indices = asks_for_indices(m), refracts = tags->met.w & NOTED_REFRACTS;
    json_object_set_new(json, "hit",
                        json_pack("{s: f, s: o, s: o, s: o, s: o, s: o, s: b, s: o, s: o, s: o, s: b, s: o}",
                                  "distance", r->origin.w, "object", origin_json(&o), "material",
                                  material_json(t, tags->met.z), "point", point_json(t, r->point), "normal",
                                  colour_json(r->normal), "shading", colour_json(r->shading), "entering",
                                  tags->met.w & NOTED_ENTERING, "reflected", colour_json(r->reflected), "transmitted",
                                  indices && refracts ? colour_json(r->transmitted) : json_null(), "indices",
                                  indices ? json_pack("[f, f]", r->direction.w, r->weight.w) : json_null(),
                                  "total_reflection", indices && !refracts, "touching", touching));
    if (!is_black(m->transmission))
        json_object_set_new(json_object_get(json, "hit"), "media_behind",
                            media_json(t, tags->behind_outer, tags->behind_inner));
    json_object_set_new(json, "local",
                        json_pack("{s: o, s: o, s: o, s: o}", "ambient", colour_json(r->ambient), "emission",
                                  colour_json(r->emission), "lights", lights, "colour", colour_json(r->lit)));
    return 0;
}

/* The eye's own rays do not see the background where it is to be transparent. */
static vec3 background_of(const story *t, const ray_tags *tags) {
    const bool hidden = tags->sent.z == RAY_EYE && t->job->settings.transparent;
    return hidden ? (vec3){0, 0, 0} : t->scene->background;
}

/* A ray and all that it sends; `colour` is what arrives along it. NULL: out of memory. */
static json_t *ray_json(const story *t, uint32_t ray, vec3 *colour, feeler_error *error) {
    static const char *const sent_as[] = {"eye", "reflection", "transmission"}, *const ways[] = {"reflection",
                                                                                                 "transmission"};
    const ray_note *r = &t->notes->rays[ray];
    const ray_tags *tags = &t->notes->ray_tags[ray];
    const bool met = tags->met.x != NOT_NOTED;
    json_t *passed = crossings_json(t, ray, NOT_NOTED, CROSSING_HIDDEN, error);
    json_t *json =
        json_pack("{s: i, s: s, s: i, s: i, s: o, s: o, s: o, s: o, s: o, s: n}", "number", (int)ray, "kind",
                  sent_as[tags->sent.z], "sample", (int)tags->sent.y, "level", (int)tags->sent.w, "origin",
                  point_json(t, r->origin), "direction", colour_json(r->direction), "weight", colour_json(r->weight),
                  "media", media_json(t, tags->before_outer, tags->before_inner), "passed", passed, "hit");
    int status = passed && json ? 0 : -1;
    *colour = met ? xyz(r->lit) : background_of(t, tags);
    if (status == 0 && met)
        status = add_hit(t, ray, json, error);
    if (status == 0 && !met)
        json_object_set_new(json, "background", vec_json(*colour));
    if (status == 0) /* to the sample's colour */
        json_object_set_new(json, "adds", vec_json(met ? vec_multiply(xyz(r->weight), *colour) : xyz(r->background)));
    for (int which = 0; status == 0 && met && which < 2; which++) {
        json_t *child = child_json(t, ray, which, colour, error);
        status = child ? json_object_set_new(json, ways[which], child) : -1;
    }
    if (status == 0)
        json_object_set_new(json, "colour", vec_json(*colour));
    if (status == 0)
        return json;
    json_decref(json);
    return NULL;
}

/* ---- trees ---- */

json_t *trees_json(const story *t, feeler_error *error) {
    json_t *trees = json_array();
    for (uint32_t ray = 0; ray < t->notes->count.x; ray++) {
        const uint4 sent = t->notes->ray_tags[ray].sent;
        vec3 colour;
        if (sent.z != RAY_EYE || (t->sample >= 0 && sent.y != (uint32_t)t->sample))
            continue;
        json_t *tree = ray_json(t, ray, &colour, error);
        if (!tree) {
            json_decref(trees);
            return NULL;
        }
        json_array_append_new(trees, tree);
    }
    return trees;
}
