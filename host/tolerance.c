/* tolerance.c - finds the cheapest way to render a picture whose error is small enough.
 *
 * A small picture, the proxy, tells which ways are worth a try and what they cost. Tiles of the picture itself tell whether
 * one does: a region is the same part of the whole, so they are measured before the whole is rendered. */
#include "clock.h"
#include "difference.h"
#include "truth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SAMPLES = 256, MOST_TRIALS = 32 };

/* A way is good enough at this share of the tolerance, as long as there are others: tiles are only a part of the picture, and
 * the truth has noise of its own. The least error that is found is judged by the tolerance itself. */
static const double safety = 0.8;
/* What the truth itself may be off by, as a share of the tolerance; that of the proxy only points the way. */
static const double proxy_noise = 1. / 2, noise_share = 1. / 3;

/* Of a picture's time, the most that level draft spares in most scenes (docs/performance.md). */
static const double draft_saving = 0.1;

typedef struct trial {
    way way;
    double proxy, seconds; /* error and time there; negative: not tried there */
    uint64_t rays;         /* that it sent there */
    double tiles;          /* error there; negative: not tried there */
} trial;

typedef struct search {
    feeler_settings settings; /* resolved */
    bool any_level, any_samples, any_cutoff;
    double tolerance;
    resident resident; /* what both render */
    truth proxy, tiles;
    bool whole;        /* the proxy is the picture itself */
    bool draft_spared; /* to compile its kernels would take longer than they may save */
    trial trials[MOST_TRIALS];
    int count;
} search;

/* ---- trials on the proxy ---- */

static bool good(const search *s, double found) {
    return found >= 0 && found <= safety * s->tolerance;
}

static trial *add_trial(search *s, way w) {
    trial *t = &s->trials[s->count++];
    *t = (trial){.way = w, .proxy = -1, .seconds = -1, .tiles = -1};
    return t;
}

/* NULL: failed. */
static const trial *try_way(search *s, way w, feeler_error *error) {
    trial *t = add_trial(s, w);
    if (truth_measure(&s->proxy, &w, &t->proxy, &t->seconds, error))
        return NULL;
    t->rays = s->proxy.rays;
    return t;
}

static way way_of(const search *s, int level, int samples) {
    return (way){level, s->any_samples ? samples : s->settings.samples, s->settings.depth, s->settings.cutoff};
}

/* The number of samples that should do, from the error of sixteen by the truth's kernel, which needs no compiling. At edges it
 * falls with their number to the power of -3/4. -1: failed. */
static int guess_samples(search *s, feeler_error *error) {
    const way w = {FEELER_REFERENCE, 16, s->settings.depth, s->settings.cutoff};
    double found;
    int n = 1;
    if (!s->any_samples)
        return s->settings.samples;
    if (truth_measure(&s->proxy, &w, &found, NULL, error))
        return -1;
    while (n < MOST_SAMPLES && !good(s, found * pow(16. / n, 0.75)))
        n *= 4;
    return n;
}

/* Up from a number of samples until the error is small enough, as long as it falls; else down while that is possible. `*best`
 * is the trial with the least good number, NULL where there is none. */
static int try_samples(search *s, int level, int first, const trial **best, feeler_error *error) {
    const trial *t = NULL;
    *best = NULL;
    for (int n = first; !*best; n *= 4) {
        const double before = t ? t->proxy : INFINITY;
        t = try_way(s, way_of(s, level, n), error);
        if (!t)
            return -1;
        if (good(s, t->proxy))
            *best = t;
        else if (!s->any_samples || n >= MOST_SAMPLES || t->proxy > 0.9 * before)
            return 0;
    }
    /* A quarter of the samples has at least twice the error: it falls with the power of -1/2 or faster. */
    for (int n = first / 4; s->any_samples && n && (*best)->way.samples == 4 * n && good(s, 2 * (*best)->proxy);
         n /= 4) {
        t = try_way(s, way_of(s, level, n), error);
        if (!t)
            return -1;
        if (good(s, t->proxy))
            *best = t;
    }
    if (!s->any_samples || !*best || (*best)->way.samples < 4 || !good(s, sqrt(2) * (*best)->proxy))
        return 0;
    t = try_way(s, way_of(s, level, (*best)->way.samples / 2), error);
    if (t && good(s, t->proxy))
        *best = t;
    return t ? 0 : -1;
}

/* Rays that carry little are spared where there are such: the same kernel is told how little. */
static int try_cutoffs(search *s, const trial *best, feeler_error *error) {
    for (double cutoff = s->tolerance; cutoff > s->tolerance / 100 && cutoff > best->way.cutoff && cutoff < 1;
         cutoff /= 4) {
        way less = best->way;
        less.cutoff = cutoff;
        const trial *t = try_way(s, less, error);
        if (!t)
            return -1;
        if (t->rays >= best->rays) { /* the same picture, and less would be spared by less */
            s->count--;
            return 0;
        }
        if (good(s, t->proxy))
            return 0;
    }
    return 0;
}

/* Seconds that the picture should take, by what the proxy took. */
static double expect_seconds(const search *s, const trial *t) {
    const int *r = s->settings.region;
    return t->seconds * (r[2] - r[0]) * (r[3] - r[1]) / (double)s->proxy.pixels;
}

static int try_ways(search *s, bool sends, feeler_error *error) {
    const trial *best = NULL;
    const int first = guess_samples(s, error);
    if (first < 0 || try_samples(s, s->any_level ? FEELER_STANDARD : s->settings.level, first, &best, error))
        return -1;
    if (s->any_level && best) {
        const int samples = best->way.samples;
        s->draft_spared = draft_saving * expect_seconds(s, best) < s->proxy.compile;
        if (!s->draft_spared && !try_way(s, way_of(s, FEELER_DRAFT, samples), error))
            return -1;
    } else if (s->any_level && try_samples(s, FEELER_REFERENCE, first, &best, error)) {
        return -1;
    }
    return best && sends && s->any_cutoff ? try_cutoffs(s, best, error) : 0;
}

/* ---- the check on tiles ---- */

static bool tried_there(const search *s, way w) {
    for (int i = 0; i < s->count; i++) {
        const way *v = &s->trials[i].way;
        if (v->level == w.level && v->samples == w.samples && v->cutoff == w.cutoff && s->trials[i].tiles >= 0)
            return true;
    }
    return false;
}

/* The cheapest way that was good on the proxy and is not checked. What is less exact must be cheaper by more than the times
 * vary by. */
static trial *next_hopeful(search *s) {
    trial *best = NULL;
    for (trial *t = s->trials; t < s->trials + s->count; t++)
        if (t->tiles < 0 && good(s, t->proxy) && (!best || t->seconds < 0.9 * best->seconds))
            best = t;
    return best;
}

/* The way with the least error, where it was checked or else on the proxy; one that follows must be better by more than
 * errors vary by. */
static trial *least_error(search *s, bool checked) {
    trial *best = NULL;
    for (trial *t = s->trials; t < s->trials + s->count; t++) {
        const double mine = checked ? t->tiles : t->proxy;
        if (mine >= 0 && (!best || mine < 0.9 * (checked ? best->tiles : best->proxy)))
            best = t;
    }
    return best;
}

/* A dearer way than the best so far: more samples, else level reference. NULL: there is none. */
static trial *next_dearer(search *s) {
    way w = least_error(s, true)->way;
    w.cutoff = s->settings.cutoff;
    for (; s->any_samples && w.samples < MOST_SAMPLES && tried_there(s, w);)
        w.samples = 4 * w.samples < MOST_SAMPLES ? 4 * w.samples : MOST_SAMPLES;
    if (s->any_level && tried_there(s, w))
        w.level = FEELER_REFERENCE;
    return tried_there(s, w) || s->count == MOST_TRIALS ? NULL : add_trial(s, w);
}

/* Measures a way on the tiles. Where the truth's own noise may be what makes it too bad, the truth gets more samples: they cost
 * less than a picture with more. */
static int measure_there(search *s, trial *t, feeler_error *error) {
    int known;
    do {
        if (truth_measure(&s->tiles, &t->way, &t->tiles, NULL, error))
            return -1;
        known = s->tiles.samples;
        if (!good(s, t->tiles) && good(s, fmax(0, t->tiles - s->tiles.noise)) &&
            truth_refine(&s->tiles, 0.75 * s->tiles.noise, error))
            return -1;
    } while (s->tiles.samples > known);
    return 0;
}

/* Checks ways from the cheapest on. The one to render with, NULL: failed. */
static trial *check(search *s, feeler_error *error) {
    trial *t = next_hopeful(s);
    if (!t)
        t = least_error(s, false);
    while (t) {
        if (measure_there(s, t, error))
            return NULL;
        if (good(s, t->tiles))
            return t;
        t = next_hopeful(s);
        if (!t)
            t = next_dearer(s);
    }
    return least_error(s, true);
}

/* ---- the report ---- */

static double error_found(const search *s, const trial *t) {
    return s->whole ? t->proxy : t->tiles;
}

static bool reached(const search *s, const trial *t) {
    return error_found(s, t) < s->tolerance;
}

/* Why the tolerance is not reached: which of the errors is above it. -1: failed. */
static int explain(search *s, const trial *chosen, char *why, size_t size, feeler_error *error) {
    truth *t = s->whole ? &s->proxy : &s->tiles;
    const way exact = {FEELER_REFERENCE, chosen->way.samples, t->depth, t->cutoff};
    double rounding = 0, sampling;
    if (t->noise > safety * s->tolerance) {
        snprintf(why, size, "it is below what is known of the truth: %d samples a pixel leave that off by %.2g",
                 t->samples, t->noise);
        return 0;
    }
    if (truth_measure(t, &exact, &sampling, NULL, error) ||
        (chosen->way.level != FEELER_REFERENCE && truth_between(t, &chosen->way, &exact, &rounding, error)))
        return -1;
    snprintf(why, size,
             "sampling with %d sample%s a pixel%s leaves an error of %.2g, which falls with their number to the power "
             "of -1/2 to -3/4; level, depth and cutoff one of %.2g",
             chosen->way.samples, chosen->way.samples == 1 ? "" : "s",
             s->any_samples ? ", the most that are tried," : "", sampling, rounding);
    return 0;
}

static json_t *describe_error(double value) {
    return value < 0 ? json_null() : json_real(value);
}

static json_t *describe_trials(const search *s) {
    json_t *list = json_array();
    for (int i = 0; i < s->count; i++) {
        const trial *t = &s->trials[i];
        if (json_array_append_new(list, json_pack("{s:s, s:i, s:f, s:o, s:o, s:o}", "level", level_name(t->way.level),
                                                  "samples", t->way.samples, "cutoff", t->way.cutoff, "proxy_error",
                                                  describe_error(t->proxy), "proxy_seconds", describe_error(t->seconds),
                                                  "error", describe_error(error_found(s, t))))) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *describe(const search *s, const trial *chosen, const char *why, double seconds) {
    const truth *t = s->whole ? &s->proxy : &s->tiles;
    const int *r = t->regions[0];
    return json_pack("{s:f, s:b, s:f, s:{s:i, s:f, s:i, s:f}, s:{s:i, s:[i,i], s:b}, s:{s:s, s:i, s:f, s:i}, s:[i,i], "
                     "s:s, s:o, s:f}",
                     "asked", s->tolerance, "reached", reached(s, chosen), "error", error_found(s, chosen), "truth",
                     "samples", t->samples, "noise", t->noise, "depth", t->depth, "cutoff", t->cutoff, "checked",
                     "tiles", t->count, "size", r[2] - r[0], r[3] - r[1], "whole", s->whole, "chosen", "level",
                     level_name(chosen->way.level), "samples", chosen->way.samples, "cutoff", chosen->way.cutoff,
                     "depth", chosen->way.depth, "proxy", s->proxy.settings.width, s->proxy.settings.height, "why", why,
                     "candidates", describe_trials(s), "seconds", seconds);
}

/* ---- all of it ---- */

static int start_search(search *s, const feeler_scene *scene, const feeler_settings *asked, feeler_device *device,
                        feeler_progress progress, void *user, feeler_error *error) {
    feeler_settings settings = *asked;
    s->any_level = asked->level == FEELER_LEVEL_ANY;
    s->any_samples = asked->samples == 0;
    s->any_cutoff = asked->cutoff < 0;
    if (s->any_level)
        settings.level = FEELER_STANDARD;
    if (!(s->tolerance > 0 && s->tolerance <= 1))
        return fail(error, FEELER_BAD_USAGE, "a tolerance of %g: it is above 0 and at most 1", s->tolerance);
    if (!device->has_double)
        return fail(error, FEELER_DEVICE, "'%s' has no double precision, which a tolerance is measured with",
                    device->name);
    if (resolve_settings(scene, &settings, &s->settings, error))
        return -1;
    /* Lanes are chosen for each way's samples. */
    s->settings.lanes = asked->lanes;
    s->proxy = (truth){.scene = scene,
                       .device = device,
                       .resident = &s->resident,
                       .progress = progress,
                       .user = user,
                       .depth = s->settings.depth > scene->depth ? s->settings.depth : scene->depth,
                       .cutoff = fmin(s->settings.cutoff, scene->cutoff)};
    s->proxy.settings = s->settings;
    s->proxy.share = 0.999;
    s->tiles = s->proxy;
    return 0;
}

/* Finds the way to render with; NULL: failed. */
static trial *find_way(search *s, feeler_error *error) {
    const uint32_t features = choose_needs(s->proxy.scene, &s->settings).features;
    const bool sends = features & (1u << FEATURE_REFLECTION | 1u << FEATURE_TRANSMISSION);
    if (truth_open_proxy(&s->proxy, &s->whole, error) ||
        truth_refine(&s->proxy, (s->whole ? noise_share : proxy_noise) * s->tolerance, error) ||
        try_ways(s, sends, error))
        return NULL;
    if (s->whole) {
        trial *t = next_hopeful(s);
        return t ? t : least_error(s, false);
    }
    if (truth_open_tiles(&s->tiles, error) || truth_refine(&s->tiles, noise_share * s->tolerance, error))
        return NULL;
    return check(s, error);
}

/* The way to render with, and why it is that one; NULL: failed. */
static const trial *choose(search *s, char *why, size_t size, feeler_error *error) {
    const trial *chosen = find_way(s, error);
    if (chosen && !reached(s, chosen))
        return explain(s, chosen, why, size, error) ? NULL : chosen;
    snprintf(why, size, "%s%s",
             chosen && good(s, error_found(s, chosen))
                 ? "the cheapest of those tried whose error is below the tolerance with a fifth to spare"
                 : "the least error of those tried, which is below the tolerance but without a fifth to spare",
             s->draft_spared ? "; draft was not tried: to compile it takes longer than it is likely to save" : "");
    return chosen;
}

feeler_image *feeler_render_within(const feeler_scene *scene, const feeler_settings *asked, double tolerance,
                                   feeler_device *device, feeler_progress progress, void *user, feeler_error *error) {
    const double start = seconds_now();
    search s = {.tolerance = tolerance};
    feeler_error own = {0};
    feeler_image *image = NULL;
    char why[512];
    const trial *chosen =
        start_search(&s, scene, asked, device, progress, user, &own) ? NULL : choose(&s, why, sizeof why, &own);
    const double seconds = seconds_now() - start;
    resident_free(&s.resident);
    if (chosen) {
        s.settings.level = chosen->way.level;
        s.settings.samples = chosen->way.samples;
        s.settings.cutoff = chosen->way.cutoff;
        image = feeler_render(scene, &s.settings, device, progress, user, &own);
    }
    if (image && image_report(image, "tolerance", describe(&s, chosen, why, seconds), &own)) {
        feeler_image_free(image);
        image = NULL;
    }
    if (own.code)
        *error = own;
    truth_close(&s.proxy);
    truth_close(&s.tiles);
    return image;
}
