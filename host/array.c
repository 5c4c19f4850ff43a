/* array.c */
#include "array.h"

#include "scene.h"

#include <stdlib.h>
#include <string.h>

/* Indices on the device are 32 bit, and lanes hold them signed. */
#define MOST_ELEMENTS ((size_t)INT32_MAX)

/* Room for `count` more elements, and unless `exact` for as many again as there are. */
static int make_room(array *a, size_t count, bool exact, feeler_error *error) {
    if (count > MOST_ELEMENTS - a->count)
        return fail(error, FEELER_BAD_INPUT, "too many %s: a scene can hold %zu", a->name, MOST_ELEMENTS);
    size_t capacity = exact ? 0 : a->capacity ? a->capacity * 2 : 16;
    if (a->data && a->count + count <= a->capacity)
        return 0;
    if (capacity < a->count + count)
        capacity = a->count + count;
    void *data = realloc(a->data, (capacity ? capacity : 1) * a->element);
    if (!data)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for %zu %s", capacity, a->name);
    a->data = data;
    a->capacity = capacity;
    return 0;
}

void *array_add(array *a, size_t count, feeler_error *error) {
    if (make_room(a, count, false, error) < 0)
        return NULL;
    char *place = (char *)a->data + a->count * a->element;
    memset(place, 0, count * a->element);
    a->count += count;
    return place;
}

int array_reserve(array *a, size_t count, feeler_error *error) {
    return make_room(a, count, true, error);
}

void narrow(const double *doubles, float *floats, size_t count) {
    for (size_t i = 0; i < count; i++)
        floats[i] = (float)doubles[i];
}
