/* render.c - from a scene to an image: pack, upload, build, launch tile by tile, collect. */
#include "bound.h"
#include "clock.h"
#include "job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_TILE_PIXELS = 1 << 16 };
static const double tile_seconds = 0.1; /* what a launch should take: progress and Ctrl-C stay quick */

static size_t region_pixels(const job *j) {
    const int *r = j->settings.region;
    return (size_t)(r[2] - r[0]) * (size_t)(r[3] - r[1]);
}

static feeler_image *new_image(const job *j, const feeler_scene *scene, feeler_error *error) {
    const int *r = j->settings.region;
    feeler_image *image = calloc(1, sizeof *image);
    if (image) {
        image->pixels = calloc(region_pixels(j), 4 * real_size(j));
        image->scene_name = strdup(scene->name ? scene->name : "");
    }
    if (!image || !image->pixels || !image->scene_name) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a picture of %d x %d pixels", r[2] - r[0], r[3] - r[1]);
        feeler_image_free(image);
        return NULL;
    }
    image->x0 = r[0];
    image->y0 = r[1];
    image->width = r[2] - r[0];
    image->height = r[3] - r[1];
    image->is_double = j->settings.level == FEELER_REFERENCE;
    image->transparent = j->settings.transparent;
    image->stats.deepest = 1;
    return image;
}

static void add_rays(job *j, const slot *s, size_t count) {
    const uint4 *rays = s->results[RESULT_RAYS].host;
    render_stats *stats = &j->image->stats;
    for (size_t i = 0; i < count; i++) {
        stats->reflection += rays[i].x;
        stats->transmission += rays[i].y;
        stats->shadow += rays[i].z;
        stats->eye_hits += rays[i].w;
    }
    stats->eye += (uint64_t)count * (uint64_t)j->settings.samples;
}

static void add_unsent(job *j, const slot *s, size_t count) {
    const float *floats = s->results[RESULT_UNSENT].host;
    const double *doubles = s->results[RESULT_UNSENT].host;
    for (size_t i = 0; i < count; i++) {
        double most = 0, one[4];
        for (size_t k = 0; k < 4; k++)
            one[k] = j->image->is_double ? doubles[4 * i + k] : (double)floats[4 * i + k];
        for (size_t k = 0; k < 3; k++) {
            j->discarded[k] = fmax(j->discarded[k], one[k]);
            most = fmax(most, one[k]);
        }
        j->discarded_sum += most;
        if ((int)one[3] > j->image->stats.deepest)
            j->image->stats.deepest = (int)one[3];
    }
}

static void copy_pixels(job *j, const slot *s) {
    const tile *t = &s->tile;
    const size_t size = 4 * real_size(j), row = (size_t)(t->x1 - t->x0) * size;
    for (int y = t->y0; y < t->y1; y++) {
        size_t at = (size_t)(y - j->image->y0) * (size_t)j->image->width + (size_t)(t->x0 - j->image->x0);
        memcpy((char *)j->image->pixels + at * size,
               (const char *)s->results[RESULT_PIXELS].host + (size_t)(y - t->y0) * row, row);
    }
}

/* The next tile twice as large while launches are short, smaller where they are long. */
static void adapt_budget(job *j, double seconds, size_t pixels) {
    if (j->settings.tile)
        return;
    double wanted = seconds > 0 ? (double)pixels * tile_seconds / seconds : (double)MOST_TILE_PIXELS;
    double most = fmin(2 * (double)j->tiles.budget, (double)j->slot_pixels);
    j->tiles.budget = (size_t)fmax(fmin(wanted, most), (double)(j->group[0] * j->group[1]));
}

/* Waits for a tile and takes its results into the image. */
static int finish_tile(job *j, slot *s, bool first, feeler_error *error) {
    if (!s->read)
        return 0;
    cl_int status = clWaitForEvents(1, &s->read);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clWaitForEvents", status);
    const size_t count = tile_pixels(&s->tile);
    /* A launch waits for the one before it: only then does its own time begin. */
    const double now = seconds_now(), wall = now - fmax(s->start, j->taken);
    const double kernel = launch_seconds(j, s), known = kernel < 0 ? wall : kernel;
    j->taken = now;
    /* A driver may compile for this group size at the first launch. */
    if (first)
        j->image->stats.compile += fmax(0, wall - known);
    j->image->stats.trace += first ? known : wall;
    j->image->stats.kernel = kernel < 0 ? -1 : j->image->stats.kernel + kernel;
    copy_pixels(j, s);
    add_rays(j, s, count);
    if (sends_rays(j))
        add_unsent(j, s, count);
    take_channels(j, s);
    adapt_budget(j, known, count);
    j->done += count;
    release_events(s);
    return 0;
}

/* Launches every tile, one ahead of the one whose results are taken. The first is awaited alone: it tells compile time. */
static int run_tiles(job *j, feeler_progress progress, void *user, feeler_error *error) {
    const double all = (double)region_pixels(j);
    int turn = 0;
    tile t;
    while (!j->stop && tiles_next(&j->tiles, &t)) {
        const bool first = j->image->stats.eye == 0 && turn == 0;
        if (start_tile(j, &j->slots[turn & 1], &t, error) < 0)
            return -1;
        if (finish_tile(j, &j->slots[first ? 0 : (turn + 1) & 1], first, error) < 0)
            return -1;
        turn++;
        j->stop = progress && progress(user, (double)j->done / all);
    }
    for (int i = 0; i < 2; i++)
        if (finish_tile(j, &j->slots[(turn + i) & 1], false, error) < 0)
            return -1;
    if (progress && !j->stop)
        j->stop = progress(user, (double)j->done / all);
    if (j->stop && (double)j->done < all)
        fail(error, FEELER_INTERRUPTED, "interrupted at %.0f %%", 100 * (double)j->done / all);
    return 0;
}

static size_t first_budget(const job *j) {
    if (j->settings.tile)
        return (size_t)j->settings.tile;
    size_t budget = (size_t)16384 / (size_t)j->settings.samples;
    return budget > 256 ? budget : 256;
}

/* A tile has at least one group's height and width of whole groups. */
static size_t slot_room(const job *j) {
    size_t room = j->settings.tile ? (size_t)j->settings.tile : MOST_TILE_PIXELS,
           least = (size_t)(j->group[0] * j->group[1]);
    if (room > region_pixels(j))
        room = region_pixels(j);
    return room > least ? room : least;
}

/* Packs the scene, unless the job was given it as it needs it. */
static int pack_job(job *j, const feeler_scene *scene, feeler_error *error) {
    const feeler_settings *s = &j->settings;
    if (j->packed.width == (size_t)j->needs.width && j->packed.is_double == (s->level == FEELER_REFERENCE))
        return 0;
    upload_free(&j->upload);
    packed_free(&j->packed);
    return pack_scene(&j->packed, scene, s, j->needs, error);
}

static int upload_job(job *j, const view *view, feeler_error *error) {
    if (!j->upload.arrays[0]) {
        j->packed.eye_inside = eye_may_be_inside(&j->packed, view->eye);
        if (upload_scene(&j->upload, &j->packed, j->device, error) < 0)
            return -1;
    }
    return upload_view(&j->upload, view, j->packed.is_double, j->needs.media, j->device, error);
}

int open_job(job *j, const feeler_scene *scene, feeler_progress progress, void *user, feeler_error *error) {
    const feeler_settings *s = &j->settings;
    if (s->level == FEELER_REFERENCE && !j->device->has_double)
        return fail(error, FEELER_DEVICE, "'%s' has no double precision, which level reference needs", j->device->name);
    j->needs = choose_needs(scene, s);
    j->needs.notes = j->notes;
    j->options = program_options(s, j->needs, error);
    if (!j->options || pack_job(j, scene, error) < 0)
        return -1;
    j->stop = progress && progress(user, 0);
    if (j->stop)
        return 0;
    const view view = pack_view(scene, s, j->packed.origin);
    if (upload_job(j, &view, error) < 0)
        return -1;
    if (program_build(&j->program, j->device, j->options, j->notes ? "record_pixel" : "render", error) < 0 ||
        choose_work_group(j->device, &j->program, s, j->needs, j->options, j->group, &j->group_from, error) < 0)
        return -1;
    if (open_survey(j, error) < 0)
        return -1;
    j->slot_pixels = slot_room(j);
    for (int i = 0; i < 2; i++)
        if (open_slot(j, &j->slots[i], error) < 0)
            return -1;
    tiles_start(&j->tiles, s->region, j->group, first_budget(j));
    bool transmits = j->needs.features >> FEATURE_TRANSMISSION & 1;
    if (!transmits)
        return 0;
    return j->packed.eye_inside ? find_eye_media(j, error) : clear_eye_media(j, error);
}

static int fill_stats(job *j, const feeler_scene *scene, double start, feeler_error *error) {
    render_stats *stats = &j->image->stats;
    double *lights = malloc((2 * scene->light_count + 1) * sizeof *lights);
    if (!lights)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    stats->truncation_bound = truncation_bound(scene, j->discarded, lights);
    free(lights);
    j->image->options = strdup(j->options);
    if (!j->image->options)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    stats->load = scene->load_seconds;
    stats->tree = j->packed.tree_seconds;
    stats->compile += j->program.seconds + j->survey.seconds;
    stats->total = stats->load + seconds_now() - start;
    stats->discarded_max = fmax(j->discarded[0], fmax(j->discarded[1], j->discarded[2]));
    stats->discarded_mean = j->done ? j->discarded_sum / (double)j->done : 0;
    snprintf(stats->device, sizeof stats->device, "%s", j->device->name);
    memcpy(stats->work_group, j->group, sizeof j->group);
    memcpy(stats->pixels, j->settings.pixels, sizeof stats->pixels);
    stats->work_group_from = group_origin_names[j->group_from];
    stats->level = j->settings.level;
    stats->lanes = j->settings.lanes;
    stats->width = j->settings.width;
    stats->height = j->settings.height;
    stats->samples = j->settings.samples;
    stats->depth = j->settings.depth;
    stats->jitter = j->settings.jitter;
    stats->cutoff = j->settings.cutoff;
    features_text(j->needs.features, stats->features, sizeof stats->features);
    return 0;
}

void close_job(job *j) {
    for (int i = 0; i < 2; i++)
        close_slot(&j->slots[i]);
    free(j->options);
    program_free(&j->program);
    program_free(&j->survey);
    upload_free(&j->upload);
    packed_free(&j->packed);
}

/* Renders the region of the settings with what is prepared. */
static int render_region(job *j, const feeler_scene *scene, double start, feeler_progress progress, void *user,
                         feeler_error *error) {
    memset(j->discarded, 0, sizeof j->discarded);
    j->discarded_sum = 0;
    j->done = 0;
    tiles_start(&j->tiles, j->settings.region, j->group, j->tiles.budget);
    j->image = new_image(j, scene, error);
    if (!j->image || open_channels(j, scene, error) < 0 || run_tiles(j, progress, user, error) < 0)
        return -1;
    return fill_stats(j, scene, start, error);
}

void resident_free(resident *r) {
    upload_free(&r->upload);
    packed_free(&r->packed);
    *r = (resident){0};
}

int render_regions(const feeler_scene *scene, const feeler_settings *settings, const int (*regions)[4], int count,
                   feeler_device *device, resident *resident, feeler_progress progress, void *user,
                   feeler_image **images, feeler_error *error) {
    double start = seconds_now();
    job j = {.device = device};
    if (resident) {
        j.packed = resident->packed;
        j.upload = resident->upload;
        memset(resident, 0, sizeof *resident);
    }
    int status = resolve_settings(scene, settings, &j.settings, error), made = 0;
    if (status == 0)
        status = open_job(&j, scene, progress, user, error);
    for (; made < count && status == 0 && (made == 0 || !j.stop); made++) {
        if (made > 0)
            memcpy(j.settings.region, regions[made], sizeof j.settings.region);
        status = render_region(&j, scene, start, progress, user, error);
        images[made] = j.image;
    }
    if (status < 0) {
        /* Nothing may still write to what is about to be freed. */
        clFinish(device->queue);
        while (made > 0)
            feeler_image_free(images[--made]);
    } else if (resident && !j.stop) {
        resident->packed = j.packed;
        resident->upload = j.upload;
        memset(&j.packed, 0, sizeof j.packed);
        memset(&j.upload, 0, sizeof j.upload);
    }
    close_job(&j);
    return status < 0 ? -1 : made;
}

feeler_image *feeler_render(const feeler_scene *scene, const feeler_settings *settings, feeler_device *device,
                            feeler_progress progress, void *user, feeler_error *error) {
    feeler_image *image;
    const int made = render_regions(scene, settings, &settings->region, 1, device, NULL, progress, user, &image, error);
    return made == 1 ? image : NULL;
}
