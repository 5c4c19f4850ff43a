/* array.c */
#include "array.h"

#include "scene.h"

#include <stdlib.h>
#include <string.h>

/* Indices on the device are 32 bit, and lanes hold them signed. */
#define MOST_ELEMENTS ((size_t)INT32_MAX)

void *array_add(array *a, size_t count, feeler_error *error) {
    if (count == 0 && !a->data)
        return array_add(a, 1, error) ? (a->count = 0, a->data) : NULL;
    if (count > MOST_ELEMENTS - a->count) {
        fail(error, FEELER_BAD_INPUT, "too many %s: a scene can hold %zu", a->name, MOST_ELEMENTS);
        return NULL;
    }
    if (a->count + count > a->capacity) {
        size_t capacity = a->capacity ? a->capacity * 2 : 16;
        if (capacity < a->count + count)
            capacity = a->count + count;
        void *data = realloc(a->data, capacity * a->element);
        if (!data) {
            fail(error, FEELER_OUT_OF_MEMORY, "out of memory for %zu %s", capacity, a->name);
            return NULL;
        }
        a->data = data;
        a->capacity = capacity;
    }
    char *place = (char *)a->data + a->count * a->element;
    memset(place, 0, count * a->element);
    a->count += count;
    return place;
}

float *narrow(const void *doubles, size_t count, feeler_error *error) {
    float *floats = malloc((count ? count : 1) * sizeof *floats);
    if (!floats) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for %zu numbers", count);
        return NULL;
    }
    for (size_t i = 0; i < count; i++)
        floats[i] = (float)((const double *)doubles)[i];
    return floats;
}
