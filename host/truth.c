/* truth.c */
#include "truth.h"

#include "difference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Samples that are added to the first half, to the second, to the first … Rows of odd numbers of cells: no way to be measured
 * has a sample in a cell of these, so its error does not cancel. */
static const int steps[] = {3 * 3, 5 * 5, 7 * 7, 9 * 9, 11 * 11, 13 * 13, 21 * 21, 23 * 23};
enum { STEPS = sizeof steps / sizeof *steps };

enum {
    REPEATS = 3,
    PROXY = 64, /* pixels of its longer side */
    TILES = 8,  /* in each direction */
    LEAST_TILE = 8,
    MOST_TILE = 12 /* pixels of a side */
};

int truth_open(truth *t, const int (*regions)[4], int count, feeler_error *error) {
    const int *r = regions[0];
    t->count = count;
    t->pixels = (size_t)count * (size_t)(r[2] - r[0]) * (size_t)(r[3] - r[1]);
    t->regions = malloc((size_t)(count > REPEATS ? count : REPEATS) * sizeof *t->regions);
    t->halves[0] = calloc(13 * t->pixels, sizeof *t->halves[0]);
    if (!t->regions || !t->halves[0]) {
        truth_close(t);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for %d regions of a picture", count);
    }
    memcpy(t->regions, regions, (size_t)count * sizeof *regions);
    t->halves[1] = t->halves[0] + 3 * t->pixels;
    t->colours = t->halves[1] + 3 * t->pixels;
    t->trial = t->colours + 3 * t->pixels;
    t->differences = t->trial + 3 * t->pixels;
    return 0;
}

void truth_close(truth *t) {
    free(t->regions);
    free(t->halves[0]);
    t->regions = NULL;
    t->halves[0] = NULL;
}

/* ---- places to measure ---- */

static int smaller(int a, int b) {
    return a < b ? a : b;
}

/* Well mixed bits (Steele et al. 2014, Fast Splittable Pseudorandom Number Generators). */
static uint32_t mix(uint64_t x) {
    x += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)(x >> 32);
}

int truth_open_proxy(truth *t, bool *whole, feeler_error *error) {
    const feeler_settings of = t->settings;
    const int *r = of.region, width = r[2] - r[0], height = r[3] - r[1];
    const double scale = fmin(1, (double)PROXY / (width > height ? width : height));
    *whole = scale == 1;
    t->settings.width = (int)fmax(1, round(scale * of.width));
    t->settings.height = (int)fmax(1, round(scale * of.height));
    const double x = (double)t->settings.width / of.width, y = (double)t->settings.height / of.height;
    const int region[1][4] = {{(int)floor(r[0] * x), (int)floor(r[1] * y),
                               smaller((int)ceil(r[2] * x), t->settings.width),
                               smaller((int)ceil(r[3] * y), t->settings.height)}};
    /* Errors are greatest at edges, whose share of the pixels grows as pixels do. */
    t->share = 1 - fmin(0.001 / scale, 0.05);
    return truth_open(t, region, 1, error);
}

/* A tile's first pixel, anywhere in the cell `i` of so many that share the pixels from low to high. */
static int place_tile(int low, int high, int i, int cells, int length, uint64_t seed) {
    const int first = low + (int)((int64_t)(high - low) * i / cells),
              next = low + (int)((int64_t)(high - low) * (i + 1) / cells);
    return first + (int)(mix(seed) % (uint32_t)(next - first - length + 1));
}

int truth_open_tiles(truth *t, feeler_error *error) {
    const int *r = t->settings.region, width = r[2] - r[0], height = r[3] - r[1];
    /* A sixteenth of the picture, as long as that is neither too few nor more than it takes. */
    const int sixteenth = (int)(sqrt((double)width * height / 16) / TILES);
    const int length = sixteenth < LEAST_TILE ? LEAST_TILE : smaller(sixteenth, MOST_TILE);
    const int side[2] = {smaller(length, width), smaller(length, height)};
    const int cells[2] = {smaller(TILES, width / side[0]), smaller(TILES, height / side[1])};
    int regions[TILES * TILES][4], count = 0;
    for (int y = 0; y < cells[1]; y++)
        for (int x = 0; x < cells[0]; x++, count++) {
            int *tile = regions[count];
            tile[0] = place_tile(r[0], r[2], x, cells[0], side[0], (uint64_t)(2 * count));
            tile[1] = place_tile(r[1], r[3], y, cells[1], side[1], (uint64_t)(2 * count + 1));
            tile[2] = tile[0] + side[0];
            tile[3] = tile[1] + side[1];
        }
    return truth_open(t, (const int(*)[4])regions, count, error);
}

/* ---- rendering ---- */

static int stop_or_go(void *user, double fraction) {
    truth *t = user;
    (void)fraction;
    t->stopped = t->stopped || (t->progress && t->progress(t->user, 0));
    return t->stopped;
}

static double seconds_of(const render_stats *s) {
    return s->kernel >= 0 ? s->kernel : s->trace;
}

static uint64_t rays_of(const render_stats *s) {
    return s->eye + s->reflection + s->transmission + s->shadow;
}

/* Renders all regions. Where there is one alone and it is quick, it is rendered more than once for the time. */
static int render(truth *t, const way *w, double jitter, double *colours, double *seconds, feeler_error *error) {
    const bool repeat = seconds && t->count == 1 && w->samples <= 16;
    const int count = repeat ? REPEATS : t->count;
    for (int i = 1; repeat && i < REPEATS; i++)
        memcpy(t->regions[i], t->regions[0], sizeof *t->regions);
    feeler_image **images = calloc((size_t)count, sizeof *images);
    if (!images)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    feeler_settings s = t->settings;
    s.channels = 0;
    s.level = w->level;
    s.samples = w->samples;
    s.depth = w->depth;
    s.cutoff = w->cutoff;
    s.jitter = jitter;
    memcpy(s.region, t->regions[0], sizeof s.region);
    const int made = render_regions(t->scene, &s, (const int(*)[4])t->regions, count, t->device, t->resident,
                                    stop_or_go, t, images, error);
    if (t->stopped) /* a render that was done just then does not say so */
        fail(error, FEELER_INTERRUPTED, "interrupted while settings were sought");
    double sum = 0, least = INFINITY;
    t->compile = made > 0 ? images[0]->stats.compile : 0;
    t->rays = 0;
    for (int i = 0; i < made; i++) {
        if (i < t->count && error->code == 0)
            image_colours(images[i], colours + 3 * t->pixels / (size_t)t->count * (size_t)i);
        sum += seconds_of(&images[i]->stats);
        t->rays += rays_of(&images[i]->stats);
        least = fmin(least, seconds_of(&images[i]->stats));
        feeler_image_free(images[i]);
    }
    free(images);
    if (seconds)
        *seconds = repeat ? least : sum;
    return error->code ? -1 : 0;
}

/* ---- the truth ---- */

/* The mean of both halves, and their distance, of which half is what the mean is off by, as both errors are independent: less
 * than that where one half has more samples. */
static void take_stock(truth *t) {
    const double all = t->weights[0] + t->weights[1];
    double *apart = t->trial;
    for (size_t i = 0; i < 3 * t->pixels; i++) {
        t->colours[i] = (t->halves[0][i] + t->halves[1][i]) / all;
        apart[i] = t->colours[i] + (t->halves[0][i] / t->weights[0] - t->halves[1][i] / t->weights[1]) / 2;
    }
    clamp_colours(t->colours, t->pixels);
    clamp_colours(apart, t->pixels);
    pixel_differences(apart, t->colours, t->pixels, t->differences);
    t->noise = quantile(t->differences, t->pixels, t->share);
}

static int add_step(truth *t, feeler_error *error) {
    const int half = t->steps & 1, samples = steps[t->steps++];
    const way w = {FEELER_REFERENCE, samples, t->depth, t->cutoff};
    if (render(t, &w, 1, t->trial, NULL, error))
        return -1;
    for (size_t i = 0; i < 3 * t->pixels; i++)
        t->halves[half][i] += samples * t->trial[i];
    t->weights[half] += samples;
    t->samples += samples;
    return 0;
}

int truth_refine(truth *t, double noise, feeler_error *error) {
    while (t->steps < 2 || (t->steps < STEPS && t->noise > noise)) {
        if (add_step(t, error))
            return -1;
        if (t->steps >= 2)
            take_stock(t);
    }
    return 0;
}

/* ---- errors ---- */

static double error_of(truth *t, const double *colours) {
    clamp_colours(t->trial, t->pixels);
    pixel_differences(t->trial, colours, t->pixels, t->differences);
    return quantile(t->differences, t->pixels, t->share);
}

int truth_measure(truth *t, const way *w, double *found, double *seconds, feeler_error *error) {
    if (render(t, w, t->settings.jitter, t->trial, seconds, error))
        return -1;
    *found = error_of(t, t->colours);
    return 0;
}

int truth_between(truth *t, const way *a, const way *b, double *found, feeler_error *error) {
    double *other = malloc(3 * t->pixels * sizeof *other);
    int status = other ? 0 : fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    if (status == 0)
        status = render(t, a, t->settings.jitter, other, NULL, error);
    if (status == 0)
        status = render(t, b, t->settings.jitter, t->trial, NULL, error);
    if (status == 0) {
        clamp_colours(other, t->pixels);
        *found = error_of(t, other);
    }
    free(other);
    return status;
}
