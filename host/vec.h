/* vec.h - arithmetic of vec3, in double precision. */
#ifndef FEELER_VEC_H
#define FEELER_VEC_H

#include "scene.h"

#include <math.h>

static inline vec3 vec_add(vec3 a, vec3 b) {
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec3 vec_subtract(vec3 a, vec3 b) {
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3 vec_scale(vec3 a, double s) {
    return (vec3){a.x * s, a.y * s, a.z * s};
}
/* By component, as colours are. */
static inline vec3 vec_multiply(vec3 a, vec3 b) {
    return (vec3){a.x * b.x, a.y * b.y, a.z * b.z};
}
static inline double vec_dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec3 vec_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* The greatest of |x|, |y|, |z|; not meaningful for NaN. */
static inline double vec_extent(vec3 a) {
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

static inline bool vec_finite(vec3 a) {
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

/* Scaled by the power of two that brings its extent into [0.5, 1): products of it neither overflow nor vanish, and a
 * scene that is scaled by a power of two keeps every bit. Zero stays zero. */
static inline vec3 vec_unit_extent(vec3 a) {
    int exponent;
    frexp(vec_extent(a), &exponent);
    return (vec3){ldexp(a.x, -exponent), ldexp(a.y, -exponent), ldexp(a.z, -exponent)};
}

static inline double vec_length(vec3 a) {
    int exponent;
    frexp(vec_extent(a), &exponent);
    vec3 scaled = vec_unit_extent(a);
    return ldexp(sqrt(vec_dot(scaled, scaled)), exponent);
}

/* Makes the length 1. False, and untouched, when it is zero or not finite. */
static inline bool vec_normalize(vec3 *a) {
    double extent = vec_extent(*a);
    if (!vec_finite(*a) || extent == 0)
        return false;
    vec3 scaled = vec_unit_extent(*a);
    *a = vec_scale(scaled, 1 / sqrt(vec_dot(scaled, scaled)));
    return true;
}

/* Whether two vectors of length 1 point the same or opposite ways, as near as matters. */
static inline bool vec_parallel(vec3 a, vec3 b) {
    return vec_length(vec_cross(a, b)) < 1e-9;
}

#endif
