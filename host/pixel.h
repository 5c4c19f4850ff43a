/* pixel.h - the ray tree of a pixel: as JSON from notes, and what is made of the JSON. */
#ifndef FEELER_PIXEL_H
#define FEELER_PIXEL_H

#include "record.h"
#include "vec.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/* Notes of a scene's pixel with what is needed to tell them: which rays, lights and crossings belong together, and which
 * primitives are of which object. */
typedef struct story {
    const feeler_scene *scene;
    const job *job;
    const notes *notes;
    int sample;               /* the one that is told, or -1: all */
    uint32_t *first_light;    /* by ray; its notes are in a row, up to the next ray's first */
    uint32_t *first_crossing; /* the same */
    uint32_t *children[2];    /* by ray: the reflection and the transmission, or NOT_NOTED */
    size_t **starts; /* by list, the scene's own first, then the groups': the objects' first primitives, or NULL */
} story;

/* Where a primitive is from: an object, a triangle of its mesh, and those inside where the object is an instance. */
typedef struct origin {
    const scene_object *object, *inside; /* inside: NULL unless the object is an instance */
    size_t number, inside_number;        /* in the scene's list; in the group's */
    size_t triangle;                     /* of the mesh, if it is one */
} origin;

static inline vec3 xyz(real4 v) {
    return (vec3){v.x, v.y, v.z};
}

/* pixel.c: names from files may be in any encoding; what is no UTF-8 becomes question marks. */
json_t *text_json(const char *text);

/* pixel_origin.c. `met`: primitive and the one inside. -1: out of memory. */
int find_origin(const story *story, uint4 met, origin *origin, feeler_error *error);
json_t *origin_json(const origin *origin);
json_t *place_json(place place);

/* pixel_rays.c: each sample's eye ray and what follows from it. NULL: out of memory. */
json_t *trees_json(const story *story, feeler_error *error);
json_t *vec_json(vec3 v);
json_t *colour_json(real4 v);
json_t *material_json(const story *story, uint32_t index); /* its name, or "materials[2]" */
/* What reaches the eye's side of a light's two terms; 0 where they do not contribute. */
void find_terms(const story *story, uint32_t light, vec3 *diffuse, vec3 *specular);

/* pixel_parts.c: what the pixel's colour is made of, the greatest first. NULL: out of memory. */
json_t *parts_json(const story *story, feeler_error *error);

/* pixel_words.c: why the pixel has its colour, in lines; takes what feeler_pixel_json makes, but for these lines. */
json_t *words_json(const json_t *pixel);
/* A member as text ("" where there is none) or as a whole number; whether all three of a colour are 0. */
const char *text_of(const json_t *object, const char *key);
int whole_of(const json_t *object, const char *key);
bool is_zero(const json_t *colour);
/* Prints "objects[2] sphere 'red'", and where `with_place` its file, line and column. `hit`: has "object" and "material". */
void print_object(FILE *out, const json_t *hit, bool with_place);
/* Prints a key as words. */
void print_key(FILE *out, const char *key);
/* Prints three numbers, or one where they are the same. */
void print_colour(FILE *out, const json_t *colour);

#endif
