/* settings.c - what a caller asks for, checked and completed by the scene's own values. */
#include "channels.h"
#include "program.h"
#include "schema.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void feeler_settings_default(feeler_settings *settings) {
    *settings = (feeler_settings){.jitter = -1, .cutoff = -1, .level = FEELER_STANDARD};
}

/* The bit of a name, or 0. */
static int channel_bit(const char *name, size_t length) {
    for (int i = 0; i < CHANNELS; i++)
        if (strlen(channel_kinds[i].name) == length && strncmp(channel_kinds[i].name, name, length) == 0)
            return 1 << i;
    return length == 3 && strncmp(name, "all", 3) == 0 ? FEELER_ALL_CHANNELS : 0;
}

static int fail_channel(const char *name, size_t length, feeler_error *error) {
    char hint[SUGGESTION_SIZE], text[SHOWN_SIZE], *copy = strndup(name, length);
    if (!copy)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    suggestion nearest = suggest_for(copy);
    for (int i = 0; i < CHANNELS; i++)
        suggest_candidate(&nearest, channel_kinds[i].name);
    fail(error, FEELER_BAD_USAGE, "unknown channel '%s'%s", shown(copy, text), suggest_text(&nearest, hint));
    free(copy);
    return -1;
}

int feeler_channels_parse(const char *names, feeler_error *error) {
    int bits = 0;
    for (const char *at = names;; at++) {
        const size_t length = strcspn(at, ",");
        const int bit = channel_bit(at, length);
        if (!bit)
            return fail_channel(at, length, error);
        bits |= bit;
        at += length;
        if (!*at)
            return bits;
    }
}

static int check_size(const feeler_settings *s, feeler_error *error) {
    if (s->width < 1 || s->width > 65536 || s->height < 1 || s->height > 65536)
        return fail(error, FEELER_BAD_USAGE, "a picture of %d x %d pixels: each side can be 1 to 65536", s->width,
                    s->height);
    if ((int64_t)s->width * s->height > INT64_C(1) << 28)
        return fail(error, FEELER_BAD_USAGE, "a picture of %d x %d pixels: at most 2^28 pixels can be rendered at once",
                    s->width, s->height);
    return 0;
}

static int check_region(const feeler_settings *s, feeler_error *error) {
    const int *r = s->region;
    if (r[0] < 0 || r[1] < 0 || r[2] > s->width || r[3] > s->height || r[0] >= r[2] || r[1] >= r[3])
        return fail(error, FEELER_BAD_USAGE, "the region %d,%d,%d,%d does not lie in the picture of %d x %d pixels",
                    r[0], r[1], r[2], r[3], s->width, s->height);
    return 0;
}

static int check_settings(const feeler_settings *s, feeler_error *error) {
    if (check_size(s, error) < 0 || check_region(s, error) < 0)
        return -1;
    if (s->samples < 1 || s->samples > 4096)
        return fail(error, FEELER_BAD_USAGE, "%d samples per pixel: 1 to 4096 are possible", s->samples);
    if (s->depth < 1 || s->depth > 256)
        return fail(error, FEELER_BAD_USAGE, "depth %d: 1 to 256 is possible", s->depth);
    if (!(s->jitter >= 0 && s->jitter <= 1))
        return fail(error, FEELER_BAD_USAGE, "jitter %g is not from 0 to 1", s->jitter);
    if (!(s->cutoff >= 0 && s->cutoff <= 1))
        return fail(error, FEELER_BAD_USAGE, "cutoff %g is not from 0 to 1", s->cutoff);
    if (s->level < FEELER_DRAFT || s->level > FEELER_REFERENCE)
        return fail(error, FEELER_BAD_USAGE, "there is no level %d", s->level);
    if (s->lanes != 1 && s->lanes != 2 && s->lanes != 4 && s->lanes != 8 && s->lanes != 16)
        return fail(error, FEELER_BAD_USAGE, "%d lanes: 1, 2, 4, 8 or 16 are possible", s->lanes);
    if (s->work_group[0] < 0 || s->work_group[1] < 0 || !s->work_group[0] != !s->work_group[1])
        return fail(error, FEELER_BAD_USAGE, "a work group of %d x %d", s->work_group[0], s->work_group[1]);
    double pixels = (double)s->pixels[0] * s->pixels[1];
    if (s->pixels[0] < 1 || s->pixels[1] < 1 || pixels > s->lanes || s->lanes % (int)pixels)
        return fail(error, FEELER_BAD_USAGE, "%d x %d pixels for %d lanes: powers of two, together at most as many",
                    s->pixels[0], s->pixels[1], s->lanes);
    if (s->channels & ~FEELER_ALL_CHANNELS)
        return fail(error, FEELER_BAD_USAGE, "there is no channel of bit %d", s->channels & ~FEELER_ALL_CHANNELS);
    if (s->tile < 0)
        return fail(error, FEELER_BAD_USAGE, "a tile of %d pixels", s->tile);
    return 0;
}

/* A ray on its own meets the eight children of a node at a time; rays together fill a vector of 64 bytes. */
static int choose_lanes(const feeler_settings *s) {
    double rays = (double)s->samples * s->pixels[0] * s->pixels[1];
    return rays <= 8 || s->level == FEELER_REFERENCE ? 8 : 16;
}

int resolve_settings(const feeler_scene *scene, const feeler_settings *asked, feeler_settings *s, feeler_error *error) {
    *s = *asked;
    if (s->width == 0)
        s->width = scene->width;
    if (s->height == 0)
        s->height = scene->height;
    if (s->samples == 0)
        s->samples = scene->samples;
    if (s->jitter < 0)
        s->jitter = scene->jitter;
    if (s->depth == 0)
        s->depth = scene->depth;
    if (s->cutoff < 0)
        s->cutoff = scene->cutoff;
    if (!s->region[0] && !s->region[1] && !s->region[2] && !s->region[3]) {
        s->region[2] = s->width;
        s->region[3] = s->height;
    }
    if (!s->pixels[0] && !s->pixels[1])
        s->pixels[0] = s->pixels[1] = 1;
    if (s->lanes == 0)
        s->lanes = choose_lanes(s);
    return check_settings(s, error);
}
