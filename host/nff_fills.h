/* nff_fills.h - the fills of an NFF file, each distinct one kept once.
 *
 * NFF repeats a fill wherever it changes, so that a file has many more fills than materials; a hash table finds the
 * earlier equal one.
 */
#ifndef FEELER_NFF_FILLS_H
#define FEELER_NFF_FILLS_H

#include "scene.h"

typedef struct nff_fill {
    double r, g, b; /* colour */
    double kd, ks;  /* diffuse and specular share */
    double shine;   /* Phong exponent; 0 or less: no highlight */
    double t;       /* transmitted share */
    double ior;     /* refractive index; 0 stands for 1 */
} nff_fill;

/* Zeroed: empty. */
typedef struct nff_fills {
    struct nff_known_fill *known; /* slots of the table */
    size_t capacity, count;       /* the capacity is a power of two, or 0 */
} nff_fills;

/* The index of the scene's material for this fill, added when it is new; -1 on failure. */
int nff_fills_material(nff_fills *fills, feeler_scene *scene, const nff_fill *fill, place place, feeler_error *error);
void nff_fills_clear(nff_fills *fills);

#endif
