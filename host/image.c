/* image.c - a finished picture and what is known about it. */
#include "image.h"

#include "scene.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

void feeler_image_free(feeler_image *image) {
    if (!image)
        return;
    free(image->pixels);
    channels_close(image);
    free(image->scene_name);
    free(image->options);
    free(image->stats_json);
    json_decref(image->reports);
    free(image);
}

feeler_image *image_new(int width, int height, feeler_error *error) {
    if (width < 1 || height < 1 || (int64_t)width * height > INT64_C(1) << 28) {
        fail(error, FEELER_BAD_INPUT, "a picture of %d x %d pixels: 1 to 2^28 pixels are possible", width, height);
        return NULL;
    }
    feeler_image *image = calloc(1, sizeof *image);
    if (image)
        image->pixels = calloc((size_t)width * (size_t)height, 4 * sizeof(double));
    if (!image || !image->pixels) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a picture of %d x %d pixels", width, height);
        feeler_image_free(image);
        return NULL;
    }
    image->width = image->stats.width = width;
    image->height = image->stats.height = height;
    image->is_double = true;
    return image;
}

feeler_image *feeler_image_from_pixels(const double *values, int width, int height, int channels, feeler_error *error) {
    if (channels != 1 && channels != 3 && channels != 4) {
        fail(error, FEELER_BAD_USAGE, "a picture of %d channels: 1, 3 or 4 are possible", channels);
        return NULL;
    }
    feeler_image *image = image_new(width, height, error);
    double *pixel = image ? image->pixels : NULL;
    for (size_t i = 0; image && i < (size_t)width * (size_t)height; i++, pixel += 4, values += channels) {
        for (int c = 0; c < 3; c++)
            pixel[c] = values[channels == 1 ? 0 : c];
        pixel[3] = channels == 4 ? values[3] : 1;
    }
    if (image)
        image->transparent = channels == 4;
    return image;
}

feeler_image *feeler_image_load(const char *path, feeler_error *error) {
    struct stat info;
    const int reason = stat(path, &info) ? errno : S_ISDIR(info.st_mode) ? EISDIR : 0;
    if (reason) {
        fail(error, FEELER_IO, "%s: cannot read: %s", path, strerror(reason));
        return NULL;
    }
    feeler_image *image = calloc(1, sizeof *image);
    if (image && image_io_read(image, path, error) == 0)
        return image;
    fail(error, FEELER_OUT_OF_MEMORY, "%s: out of memory", path);
    feeler_image_free(image);
    return NULL;
}

int feeler_image_width(const feeler_image *image) {
    return image->width;
}

int feeler_image_height(const feeler_image *image) {
    return image->height;
}

const void *feeler_image_pixels(const feeler_image *image) {
    return image->pixels;
}

int feeler_image_is_double(const feeler_image *image) {
    return image->is_double;
}

const char *level_name(int level) {
    static const char *const names[] = {"draft", "standard", "reference"};
    return level >= FEELER_DRAFT && level <= FEELER_REFERENCE ? names[level] : "unknown";
}

static json_t *list_of_words(const char *words) {
    json_t *list = json_array();
    while (list && *(words += strspn(words, " "))) {
        size_t length = strcspn(words, " ");
        if (json_array_append_new(list, json_stringn(words, length))) {
            json_decref(list);
            return NULL;
        }
        words += length;
    }
    return list;
}

/* JSON has no infinity: a bound that does not exist is said in words. */
json_t *describe_bound(double value) {
    return isfinite(value) ? json_real(value) : json_string("unbounded");
}

/* How the picture was made. `o` hands a new reference over, so that a NULL in it makes the whole fail. */
static json_t *describe_settings(const feeler_image *image) {
    const render_stats *s = &image->stats;
    return json_pack("{s:s, s:s, s:[i,i], s:s, s:[i,i], s:i, s:s, s:[i,i], s:[i,i,i,i], s:i, s:f, s:i, s:f, s:o, s:s}",
                     "version", feeler_version(), "device", s->device, "work_group", s->work_group[0], s->work_group[1],
                     "work_group_from", s->work_group_from, "pixels", s->pixels[0], s->pixels[1], "lanes", s->lanes,
                     "level", level_name(s->level), "size", s->width, s->height, "region", image->x0, image->y0,
                     image->x0 + image->width, image->y0 + image->height, "samples", s->samples, "jitter", s->jitter,
                     "depth", s->depth, "cutoff", s->cutoff, "features", list_of_words(s->features), "options",
                     image->options);
}

/* What it took. */
static json_t *describe_work(const render_stats *s) {
    json_t *kernel = s->kernel < 0 ? json_null() : json_real(s->kernel);
    return json_pack("{s:{s:I, s:I, s:I, s:I, s:I}, s:{s:f, s:f, s:f, s:f, s:o, s:f, s:f}, s:i, s:{s:f, s:f}, s:o}",
                     "rays", "eye", (json_int_t)s->eye, "eye_hits", (json_int_t)s->eye_hits, "reflection",
                     (json_int_t)s->reflection, "transmission", (json_int_t)s->transmission, "shadow",
                     (json_int_t)s->shadow, "seconds", "load", s->load, "tree", s->tree, "compile", s->compile, "trace",
                     s->trace, "kernel", kernel, "write", s->write, "total", s->total, "deepest_level", s->deepest,
                     "discarded_weight", "max", s->discarded_max, "mean", s->discarded_mean, "truncation_bound",
                     describe_bound(s->truncation_bound));
}

int image_report(feeler_image *image, const char *key, json_t *report, feeler_error *error) {
    if (!image->reports)
        image->reports = json_object();
    if (json_object_set_new(image->reports, key, report))
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory while describing the picture");
    return 0;
}

const char *feeler_image_stats_json(feeler_image *image, feeler_error *error) {
    if (!image->options) {
        fail(error, FEELER_BAD_USAGE, "this picture was not rendered: it has no statistics");
        return NULL;
    }
    json_t *root = describe_settings(image);
    json_t *work = describe_work(&image->stats);
    char *text = NULL;
    /* Saving adds to the times, so an earlier text may be out of date. */
    if (root && work && json_object_update(root, work) == 0 &&
        (!image->reports || json_object_update(root, image->reports) == 0))
        text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    json_decref(root);
    json_decref(work);
    if (!text) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory while describing the picture");
        return NULL;
    }
    free(image->stats_json);
    image->stats_json = text;
    return text;
}
