/* difference.h - how far two pictures are apart. */
#ifndef FEELER_DIFFERENCE_H
#define FEELER_DIFFERENCE_H

#include "image.h"

#include <jansson.h>

/* A picture's linear colours, three for each pixel; not a number, all three, where one is not finite. */
void image_colours(const feeler_image *image, double *colours);
/* As all figures take them: clamped to 0 … 1. */
void clamp_colours(double *colours, size_t pixels);
/* For each pixel the greatest difference of its three channels; 1, the greatest there can be, where one is not finite. */
void pixel_differences(const double *a, const double *b, size_t pixels, double *differences);
/* The value that a share of all do not exceed, linear between neighbours as numpy.percentile's. Sorts. 0 of none. */
double quantile(double *values, size_t count, double share);
/* A new reference; NULL: out of memory. */
json_t *describe_difference(const feeler_difference *difference);

#endif
