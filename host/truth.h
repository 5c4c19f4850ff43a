/* truth.h - parts of a picture as they would be with endless samples at level reference, as far as that is known. */
#ifndef FEELER_TRUTH_H
#define FEELER_TRUTH_H

#include "job.h"

/* How a picture may be rendered. */
typedef struct way {
    int level, samples, depth;
    double cutoff;
} way;

typedef struct truth {
    const feeler_scene *scene;
    feeler_device *device;
    resident *resident; /* the scene as it was rendered last */
    feeler_progress progress;
    void *user;
    feeler_settings settings; /* of the whole picture */
    int depth;                /* that the truth has, and its cutoff */
    double cutoff;
    bool stopped;      /* by progress */
    double share;      /* the percentile that an error is, 0 … 1 */
    int (*regions)[4]; /* owned; of one size */
    int count;
    size_t pixels;      /* of all regions */
    int steps, samples; /* that it has */
    double noise;       /* what the truth itself is off by, as far as its two halves tell */
    double compile;     /* seconds that the kernels of the last way took */
    uint64_t rays;      /* that the last way sent */
    double *halves[2];  /* sums of colours by weight; the first is owned and holds all below, too */
    double weights[2];
    double *colours; /* the truth, clamped */
    double *trial, *differences;
} truth;

/* Of these regions of one size (copied), for what the first members up to `share` say. -1: out of memory. */
int truth_open(truth *t, const int (*regions)[4], int count, feeler_error *error);
/* Of the settings' region in a picture of at most 64 pixels on its longer side; `*whole` if that is the region itself. */
int truth_open_proxy(truth *t, bool *whole, feeler_error *error);
/* Of up to 64 tiles, one in each part of the settings' region, always the same. */
int truth_open_tiles(truth *t, feeler_error *error);
void truth_close(truth *t);
/* More samples, until the noise is at most `noise` or there are as many as it takes; those that are there are kept. */
int truth_refine(truth *t, double noise, feeler_error *error);
/* Renders the regions in a way. `*found` is the error, `*seconds` (unless NULL) the least time it took. */
int truth_measure(truth *t, const way *way, double *found, double *seconds, feeler_error *error);
/* How far two ways are apart. */
int truth_between(truth *t, const way *a, const way *b, double *found, feeler_error *error);

#endif
