/* transform.h - affine maps, and what becomes of an object under one. */
#ifndef FEELER_TRANSFORM_H
#define FEELER_TRANSFORM_H

#include "scene.h"

/* The upper three rows of a 4 x 4 matrix whose last is 0 0 0 1; it multiplies column vectors from the left. */
typedef struct matrix {
    double m[3][4];
} matrix;

matrix matrix_identity(void);
/* First b, then a. */
matrix matrix_multiply(const matrix *a, const matrix *b);
matrix matrix_translation(vec3 by);
/* Right-handed, about the line through the origin; exact at multiples of 90 degrees about a coordinate axis. The axis
 * has any length but zero. */
matrix matrix_rotation(vec3 axis, double degrees);
matrix matrix_scaling(vec3 by);
/* Whether every element is finite, and whether it has an inverse to speak of. */
bool matrix_finite(const matrix *matrix);
bool matrix_singular(const matrix *matrix);

/* Moves an object into the space that `matrix`, finite and not singular, maps to. A box that is then not axis-aligned
 * becomes a mesh; a mirrored surface keeps its front outside. Fails where the shape has no such image. */
int transform_object(const matrix *matrix, scene_object *object, feeler_error *error);

#endif
