/* difference.c - how far two pictures are apart, in figures and as a picture. */
#include "difference.h"
#include "flip.h"
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double flip_threshold = 1. / 255;

static double value_at(const feeler_image *image, size_t index) {
    return image->is_double ? ((const double *)image->pixels)[index] : (double)((const float *)image->pixels)[index];
}

static size_t pixels_of(const feeler_image *image) {
    return (size_t)image->width * (size_t)image->height;
}

void image_colours(const feeler_image *image, double *colours) {
    for (size_t i = 0; i < pixels_of(image); i++, colours += 3) {
        double sum = 0;
        for (size_t c = 0; c < 3; c++)
            sum += 0 * (colours[c] = value_at(image, 4 * i + c)); /* 0, or not a number */
        for (size_t c = 0; c < 3; c++)
            colours[c] += sum;
    }
}

void clamp_colours(double *colours, size_t pixels) {
    for (size_t i = 0; i < 3 * pixels; i++)
        if (!isnan(colours[i]))
            colours[i] = fmin(fmax(colours[i], 0), 1);
}

void pixel_differences(const double *a, const double *b, size_t pixels, double *differences) {
    for (size_t i = 0; i < 3 * pixels; i += 3) {
        double most = 0;
        for (size_t c = i; c < i + 3; c++)
            most = fmax(most, fabs(a[c] - b[c]));
        differences[i / 3] = isnan(a[i] + b[i]) ? 1 : most;
    }
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double quantile(double *values, size_t count, double share) {
    if (count == 0)
        return 0;
    qsort(values, count, sizeof *values, by_size);
    const double at = share * (double)(count - 1);
    const size_t below = (size_t)at, above = below + 1 < count ? below + 1 : below;
    return values[below] + (at - (double)below) * (values[above] - values[below]);
}

/* ---- the figures ---- */

/* Two pictures' colours and room for a number for each pixel. */
typedef struct pair {
    size_t pixels;
    double *a, *b, *work; /* the first is owned and holds the others */
} pair;

static int check_sizes(const feeler_image *a, const feeler_image *b, feeler_error *error) {
    if (a->width != b->width || a->height != b->height)
        return fail(error, FEELER_BAD_INPUT, "the pictures' sizes differ: %d x %d and %d x %d pixels", a->width,
                    a->height, b->width, b->height);
    /* A file that knows no region says that it is the whole. */
    const bool same_whole = a->stats.width == b->stats.width && a->stats.height == b->stats.height;
    if (same_whole && (a->x0 != b->x0 || a->y0 != b->y0))
        return fail(error, FEELER_BAD_INPUT,
                    "the pictures show different regions: one begins at pixel %d,%d, the other at %d,%d", a->x0, a->y0,
                    b->x0, b->y0);
    return 0;
}

static int open_pair(pair *p, const feeler_image *a, const feeler_image *b, feeler_error *error) {
    *p = (pair){.pixels = pixels_of(a)};
    if (check_sizes(a, b, error))
        return -1;
    p->a = malloc(7 * p->pixels * sizeof *p->a);
    if (!p->a)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory to compare pictures of %d x %d pixels", a->width,
                    a->height);
    p->b = p->a + 3 * p->pixels;
    p->work = p->b + 3 * p->pixels;
    image_colours(a, p->a);
    image_colours(b, p->b);
    clamp_colours(p->a, 2 * p->pixels);
    return 0;
}

/* Root of the mean square over the channels of those pixels whose difference is not over `most`. */
static double root_mean_square(const pair *p, double most) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < p->pixels; i++) {
        if (p->work[i] > most)
            continue;
        count++;
        for (size_t c = 3 * i; c < 3 * i + 3; c++)
            sum += isnan(p->a[c] + p->b[c]) ? 1 : (p->a[c] - p->b[c]) * (p->a[c] - p->b[c]);
    }
    return count ? sqrt(sum / (3 * (double)count)) : 0;
}

static void measure(const pair *p, feeler_difference *d) {
    size_t values = 0;
    pixel_differences(p->a, p->b, p->pixels, p->work);
    d->rmse = root_mean_square(p, 1);
    d->value_rmse = root_mean_square(p, flip_threshold);
    d->p999 = quantile(p->work, p->pixels, 0.999);
    d->max = p->work[p->pixels - 1];
    while (values < p->pixels && p->work[values] <= flip_threshold)
        values++;
    d->pixels = (int64_t)p->pixels;
    d->flips = (int64_t)(p->pixels - values);
    d->share = (double)d->flips / (double)p->pixels;
    d->value_max = values ? p->work[values - 1] : 0;
    d->value_p999 = quantile(p->work, values, 0.999);
    for (size_t i = 0; i < p->pixels; i++)
        d->nonfinite += isnan(p->a[3 * i] + p->b[3 * i]);
}

int feeler_compare(const feeler_image *image, const feeler_image *reference, feeler_difference *difference,
                   feeler_error *error) {
    feeler_difference d = {0};
    pair p;
    int status = open_pair(&p, image, reference, error);
    if (status == 0)
        measure(&p, &d);
    if (status == 0)
        status = flip_errors(p.b, p.a, image->width, image->height, p.work, error);
    for (size_t i = 0; i < p.pixels && status == 0; i++)
        d.flip += p.work[i] / (double)p.pixels;
    if (status == 0)
        *difference = d;
    free(p.a);
    return status;
}

json_t *describe_difference(const feeler_difference *d) {
    return json_pack("{s:I, s:I, s:f, s:f, s:f, s:f, s:f, s:I, s:{s:f, s:f, s:f}}", "pixels", (json_int_t)d->pixels,
                     "nonfinite", (json_int_t)d->nonfinite, "max", d->max, "p99.9", d->p999, "rmse", d->rmse, "flip",
                     d->flip, "share", d->share, "flips", (json_int_t)d->flips, "values", "max", d->value_max, "p99.9",
                     d->value_p999, "rmse", d->value_rmse);
}

char *feeler_difference_json(const feeler_difference *difference, feeler_error *error) {
    json_t *object = describe_difference(difference);
    char *text = object ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(15)) : NULL;
    json_decref(object);
    if (!text)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory while describing a difference");
    return text;
}

/* ---- the picture ---- */

/* The greatest power of two by which all but a thousandth of the pixels stay below 1. */
static double choose_factor(const pair *p) {
    int exponent;
    pixel_differences(p->a, p->b, p->pixels, p->work);
    double most = quantile(p->work, p->pixels, 0.999);
    if (most == 0)
        most = p->work[p->pixels - 1];
    if (most == 0)
        return 1;
    frexp(most, &exponent);
    return ldexp(1, -exponent);
}

static int fill_difference(pair *p, const feeler_image *shape, int map, double *factor, double *out,
                           feeler_error *error) {
    if (*factor == 0)
        *factor = map == FEELER_MAP_FLIP ? 1 : choose_factor(p);
    if (map == FEELER_MAP_FLIP && flip_errors(p->b, p->a, shape->width, shape->height, p->work, error))
        return -1;
    for (size_t i = 0; i < p->pixels; i++) {
        for (size_t c = 0; c < 3; c++) {
            const double difference = fabs(p->a[3 * i + c] - p->b[3 * i + c]);
            out[4 * i + c] = *factor * (map == FEELER_MAP_FLIP ? p->work[i] : isnan(difference) ? 1 : difference);
        }
        out[4 * i + 3] = 1;
    }
    return 0;
}

feeler_image *feeler_difference_image(const feeler_image *image, const feeler_image *reference, int map, double *factor,
                                      feeler_error *error) {
    feeler_image *out = NULL;
    pair p;
    if (map != FEELER_MAP_ABSOLUTE && map != FEELER_MAP_FLIP) {
        fail(error, FEELER_BAD_USAGE, "there is no map %d", map);
        return NULL;
    }
    if (open_pair(&p, image, reference, error))
        return NULL;
    out = image_new(image->width, image->height, error);
    if (out && fill_difference(&p, image, map, factor, out->pixels, error)) {
        feeler_image_free(out);
        out = NULL;
    }
    if (out) {
        out->x0 = image->x0;
        out->y0 = image->y0;
        out->stats.width = image->stats.width;
        out->stats.height = image->stats.height;
    }
    free(p.a);
    return out;
}
