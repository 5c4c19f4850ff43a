/* array.h - growing arrays of the device's elements, on the host. */
#ifndef FEELER_ARRAY_H
#define FEELER_ARRAY_H

#include "feeler.h"

#include <stdbool.h>

typedef struct array {
    const char *name;
    size_t element; /* bytes, in double */
    bool is_real;   /* made of reals: halves when narrowed to float */
    void *data;     /* owned */
    size_t count, capacity;
} array;

/* The place of `count` new elements, zeroed; NULL when out of memory (never for 0 elements otherwise). */
void *array_add(array *array, size_t count, feeler_error *error);

/* Room for `count` more elements, none of them touched: what is never written takes no memory. The caller counts those that
 * it writes. */
int array_reserve(array *array, size_t count, feeler_error *error);

/* Rounds `count` doubles to floats. */
void narrow(const double *doubles, float *floats, size_t count);

#endif
