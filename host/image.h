/* image.h - a rendered picture and what is known about how it came to be. */
#ifndef FEELER_IMAGE_H
#define FEELER_IMAGE_H

#include "channels.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct render_stats {
    uint64_t eye, eye_hits, reflection, transmission, shadow; /* rays sent, by kind */
    int deepest;                                              /* deepest level reached, the eye ray's being 1 */
    double load, tree, compile, trace, write, total;          /* seconds of the wall clock */
    double kernel;                                            /* seconds on the device; -1: the queue does not tell */
    double discarded_max, discarded_mean;                     /* weight of rays not sent, per pixel and channel */
    double truncation_bound; /* greatest error by truncation, per channel; infinite: unbounded */
    char device[256];
    int work_group[2], pixels[2];
    const char *work_group_from; /* "given", "forced", "tuned" or "chosen"; static */
    int level, lanes;
    int width, height; /* of the whole picture */
    int samples, depth;
    double jitter, cutoff;
    char features[1024]; /* names, separated by spaces */
} render_stats;

struct feeler_image {
    int x0, y0;        /* of the region in the picture, pixels */
    int width, height; /* of the region */
    bool is_double;
    void *pixels; /* owned; width x height x 4 float or double, linear RGBA */
    bool transparent;
    void *channels[CHANNELS]; /* owned; NULL: not asked for */
    char **materials;         /* owned, and their names; only beside the channel */
    size_t material_count;
    char *scene_name; /* owned */
    char *options;    /* the kernels' build options; owned; NULL: no render made it */
    render_stats stats;
    struct json_t *reports; /* what else the statistics say: see verify.c and tolerance.c; owned; may be NULL */
    char *stats_json;       /* owned, made on request */
};

/* Adds a report to the picture's statistics; takes it. -1: out of memory, as where it is NULL. */
int image_report(feeler_image *image, const char *key, struct json_t *report, feeler_error *error);
/* "draft", "standard", "reference". Static. */
const char *level_name(int level);
/* A number, or "unbounded" where it is infinite; a new reference. */
struct json_t *describe_bound(double value);

/* A black picture of doubles that no render made; NULL: bad size or out of memory. */
feeler_image *image_new(int width, int height, feeler_error *error);

/* 0, or -1 when it is known that no picture can be written. `path` begins the message. */
int image_io_known(const char *path, feeler_error *error);
/* image_io.cpp, in a library of its own (image_plugin.c). Writes the whole file under exactly this
 * name, in the format that `format_name` ("x.exr" or only the ending) tells. */
int image_io_write(const feeler_image *image, const char *path, const char *format_name,
                   const feeler_save_options *options, feeler_error *error);
int feeler_image_io_write(const feeler_image *image, const char *path, const char *format_name,
                          const feeler_save_options *options, feeler_error *error);
/* Fills an empty image, as feeler_image_load gives it. What it allocated on failure is the image's to free. */
int image_io_read(feeler_image *image, const char *path, feeler_error *error);
int feeler_image_io_read(feeler_image *image, const char *path, feeler_error *error);

#endif
