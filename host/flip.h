/* flip.h - the perceived difference of two pictures that take turns on a screen. */
#ifndef FEELER_FLIP_H
#define FEELER_FLIP_H

#include "feeler.h"

/* LDR-FLIP of each pixel, 0 … 1, at 67 pixels per degree of sight. Colours are linear RGB, 0 … 1, three for each pixel; one
 * that is not a number counts as black in its surroundings and as 1 itself. 0, or -1 when out of memory. */
int flip_errors(const double *reference, const double *test, int width, int height, double *errors,
                feeler_error *error);

#endif
