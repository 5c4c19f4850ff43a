/* transform.h - affine maps, and what becomes of an object under one. */
#ifndef FEELER_TRANSFORM_H
#define FEELER_TRANSFORM_H

#include "scene.h"

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
/* Whether the linear part is the identity. */
bool matrix_translates(const matrix *matrix);
/* The inverse of the linear part, of a matrix that is finite and not singular; the last column is zero. */
matrix matrix_inverse_linear(const matrix *matrix);
vec3 matrix_apply(const matrix *matrix, vec3 point);
/* The box around the image of a box: its middle's image, and as far as the absolute linear part takes its half. */
void matrix_apply_to_box(const matrix *matrix, vec3 *low, vec3 *high);

/* Moves an object into the space that `matrix`, finite and not singular, maps to. A box that is then not axis-aligned
 * becomes a mesh; a mirrored surface keeps its front outside. 1, and the object untouched: the shape has no such image, it
 * takes an instance. */
int transform_object(const matrix *matrix, scene_object *object, feeler_error *error);

#endif
