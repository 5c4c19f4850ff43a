/* bound.h - the error that unsent rays may have made. */
#ifndef FEELER_BOUND_H
#define FEELER_BOUND_H

#include "scene.h"

/* The greatest error that unsent rays made, per channel, for the greatest unsent weight of a pixel per channel; infinite
 * where the model gives no bound. `lights` is room for two numbers per light. */
double truncation_bound(const feeler_scene *scene, const double discarded[3], double *lights);

#endif
