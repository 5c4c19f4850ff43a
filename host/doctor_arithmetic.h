/* doctor_arithmetic.h - does a device calculate as the host does? */
#ifndef FEELER_DOCTOR_ARITHMETIC_H
#define FEELER_DOCTOR_ARITHMETIC_H

#include "device.h"

typedef struct arithmetic {
    int count;                                        /* of values tried */
    int wrong_divisions, wrong_roots, fused, flushed; /* of these, how many differ from the host's bits */
} arithmetic;

/* Builds and runs a small kernel in float or double. 0, or -1 with the error (and build log). */
int arithmetic_try(const feeler_device *device, bool doubles, arithmetic *result, feeler_error *error);

#endif
