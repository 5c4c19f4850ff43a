/* render.c - from a scene to an image: pack, upload, build, launch tile by tile. */
#include "render.h"

#include "clock.h"
#include "image.h"
#include "program.h"
#include "tiles.h"
#include "upload.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A launch's results, on the device and here. Two take turns, so that the device never waits for the host. */
typedef struct slot {
    cl_mem pixels, discarded, tallies;
    void *host_pixels, *host_discarded;
    tally *host_tallies;
    cl_event launched, read;
    tile tile;
    double start;
} slot;

typedef struct job {
    feeler_device *device;
    feeler_settings settings; /* resolved */
    uint32_t features;
    int media;
    packed packed;
    upload upload;
    program program;
    slot slots[2];
    size_t slot_pixels; /* room in a slot */
    int group[2];
    tiles tiles;
    feeler_image *image;
    double discarded[3], discarded_sum; /* greatest per channel; sum over pixels of the greatest channel */
    size_t done;                        /* pixels */
} job;

enum { MOST_TILE_PIXELS = 1 << 18 };
static const double tile_seconds = 0.1; /* what a launch should take: progress and Ctrl-C stay quick */

static size_t real_size(const job *j) {
    return j->settings.level == FEELER_REFERENCE ? sizeof(double) : sizeof(float);
}

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
    return image;
}

static int open_slot(job *j, slot *s, feeler_error *error) {
    size_t colours = j->slot_pixels * 4 * real_size(j), tallies = j->slot_pixels * sizeof(tally);
    cl_context context = j->device->context;
    cl_int status;
    s->host_pixels = malloc(colours);
    s->host_discarded = malloc(colours);
    s->host_tallies = malloc(tallies);
    if (!s->host_pixels || !s->host_discarded || !s->host_tallies)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a tile of %zu pixels", j->slot_pixels);
    s->pixels = clCreateBuffer(context, CL_MEM_WRITE_ONLY, colours, NULL, &status);
    if (status == CL_SUCCESS)
        s->discarded = clCreateBuffer(context, CL_MEM_WRITE_ONLY, colours, NULL, &status);
    if (status == CL_SUCCESS)
        s->tallies = clCreateBuffer(context, CL_MEM_WRITE_ONLY, tallies, NULL, &status);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clCreateBuffer", status);
}

static void close_slot(slot *s) {
    if (s->read)
        clReleaseEvent(s->read);
    if (s->launched)
        clReleaseEvent(s->launched);
    if (s->pixels)
        clReleaseMemObject(s->pixels);
    if (s->discarded)
        clReleaseMemObject(s->discarded);
    if (s->tallies)
        clReleaseMemObject(s->tallies);
    free(s->host_pixels);
    free(s->host_discarded);
    free(s->host_tallies);
}

/* The parameters that every entry point begins with, and the next index. */
static cl_uint bind_scene(cl_kernel kernel, const upload *u, cl_int *status) {
    cl_uint i = 0;
    for (; i < ARRAY_COUNT; i++)
        *status |= clSetKernelArg(kernel, i, sizeof(cl_mem), &u->arrays[i]);
    *status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &u->view);
    return i;
}

static launch make_launch(const job *j, const tile *t) {
    const array *arrays = j->packed.arrays;
    size_t planes = arrays[ARRAY_PRIMITIVES].count - j->packed.bounded;
    return (launch){
        .tile = {(uint32_t)t->x0, (uint32_t)t->y0, (uint32_t)t->x1, (uint32_t)t->y1},
        .frame = {(uint32_t)j->settings.width, (uint32_t)j->settings.height, (uint32_t)j->settings.samples,
                  (uint32_t)j->settings.depth},
        .count = {(uint32_t)arrays[ARRAY_LIGHTS].count, (uint32_t)j->packed.bounded,
                  (uint32_t)arrays[ARRAY_NODES].count, (uint32_t)planes},
    };
}

static int find_eye_media(job *j, feeler_error *error) {
    cl_int status = CL_SUCCESS;
    cl_kernel kernel = j->program.find_eye_media;
    const launch frame = make_launch(j, &(tile){0, 0, 0, 0});
    cl_uint i = bind_scene(kernel, &j->upload, &status);
    status |= clSetKernelArg(kernel, i++, sizeof frame, &frame);
    status |= clSetKernelArg(kernel, i, sizeof(cl_mem), &j->upload.eye_media);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clSetKernelArg", status);
    const size_t one = 1;
    status = clEnqueueNDRangeKernel(j->device->queue, kernel, 1, NULL, &one, &one, 0, NULL, NULL);
    if (status == CL_SUCCESS)
        status = clFinish(j->device->queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueNDRangeKernel", status);
}

static int bind_render(job *j, const slot *s, feeler_error *error) {
    cl_int status = CL_SUCCESS;
    cl_kernel kernel = j->program.render;
    const launch frame = make_launch(j, &s->tile);
    cl_uint i = bind_scene(kernel, &j->upload, &status);
    status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &j->upload.eye_media);
    status |= clSetKernelArg(kernel, i++, sizeof frame, &frame);
    status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &s->pixels);
    status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &s->discarded);
    status |= clSetKernelArg(kernel, i, sizeof(cl_mem), &s->tallies);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clSetKernelArg", status);
}

static size_t tile_pixels(const tile *t) {
    return (size_t)(t->x1 - t->x0) * (size_t)(t->y1 - t->y0);
}

static size_t round_up(int length, int by) {
    return (size_t)((length + by - 1) / by) * (size_t)by;
}

/* Launches a tile and asks for its results; waits for nothing. */
static int start_tile(job *j, slot *s, const tile *t, feeler_error *error) {
    cl_command_queue queue = j->device->queue;
    s->tile = *t;
    s->start = seconds_now();
    if (bind_render(j, s, error) < 0)
        return -1;
    const size_t local[2] = {(size_t)j->group[0], (size_t)j->group[1]}, count = tile_pixels(t);
    const size_t global[2] = {round_up(t->x1 - t->x0, j->group[0]), round_up(t->y1 - t->y0, j->group[1])};
    cl_int status = clEnqueueNDRangeKernel(queue, j->program.render, 2, NULL, global, local, 0, NULL, &s->launched);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clEnqueueNDRangeKernel", status);
    const size_t colours = count * 4 * real_size(j);
    status = clEnqueueReadBuffer(queue, s->pixels, CL_FALSE, 0, colours, s->host_pixels, 1, &s->launched, NULL);
    if (status == CL_SUCCESS)
        status =
            clEnqueueReadBuffer(queue, s->discarded, CL_FALSE, 0, colours, s->host_discarded, 1, &s->launched, NULL);
    if (status == CL_SUCCESS)
        status = clEnqueueReadBuffer(queue, s->tallies, CL_FALSE, 0, count * sizeof(tally), s->host_tallies, 1,
                                     &s->launched, &s->read);
    if (status == CL_SUCCESS)
        status = clFlush(queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueReadBuffer", status);
}

static void add_tallies(job *j, const slot *s, size_t count) {
    render_stats *stats = &j->image->stats;
    for (size_t i = 0; i < count; i++) {
        const tally *t = &s->host_tallies[i];
        stats->reflection += t->rays.x;
        stats->transmission += t->rays.y;
        stats->shadow += t->rays.z;
        stats->eye_hits += t->rays.w;
        if ((int)t->extreme.x > stats->deepest)
            stats->deepest = (int)t->extreme.x;
    }
    stats->eye += (uint64_t)count * (uint64_t)j->settings.samples;
}

static void add_discarded(job *j, const slot *s, size_t count) {
    const float *floats = s->host_discarded;
    const double *doubles = s->host_discarded;
    for (size_t i = 0; i < count; i++) {
        double most = 0;
        for (int k = 0; k < 3; k++) {
            double w = j->image->is_double ? doubles[4 * i + (size_t)k] : (double)floats[4 * i + (size_t)k];
            j->discarded[k] = fmax(j->discarded[k], w);
            most = fmax(most, w);
        }
        j->discarded_sum += most;
    }
}

static void copy_pixels(job *j, const slot *s) {
    const tile *t = &s->tile;
    const size_t size = 4 * real_size(j), row = (size_t)(t->x1 - t->x0) * size;
    for (int y = t->y0; y < t->y1; y++) {
        size_t at = (size_t)(y - j->image->y0) * (size_t)j->image->width + (size_t)(t->x0 - j->image->x0);
        memcpy((char *)j->image->pixels + at * size, (const char *)s->host_pixels + (size_t)(y - t->y0) * row, row);
    }
}

/* How long the launch ran on the device; negative where the queue does not tell. */
static double launch_seconds(const slot *s) {
    cl_ulong start, end;
    if (clGetEventProfilingInfo(s->launched, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(s->launched, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) != CL_SUCCESS)
        return -1;
    return 1e-9 * (double)(end - start);
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
    double wall = seconds_now() - s->start, seconds = launch_seconds(s);
    if (seconds < 0)
        seconds = wall;
    /* A driver may compile for this group size at the first launch. */
    if (first)
        j->image->stats.compile += fmax(0, wall - seconds);
    j->image->stats.trace += seconds;
    copy_pixels(j, s);
    add_tallies(j, s, count);
    add_discarded(j, s, count);
    adapt_budget(j, seconds, count);
    j->done += count;
    clReleaseEvent(s->read);
    clReleaseEvent(s->launched);
    s->read = s->launched = NULL;
    return 0;
}

/* Launches every tile, one ahead of the one whose results are taken. The first is awaited alone: it tells compile time. */
static int run_tiles(job *j, feeler_progress progress, void *user, feeler_error *error) {
    const double all = (double)region_pixels(j);
    int stop = 0, turn = 0;
    tile t;
    while (!stop && tiles_next(&j->tiles, &t)) {
        const bool first = j->image->stats.eye == 0 && turn == 0;
        if (start_tile(j, &j->slots[turn & 1], &t, error) < 0)
            return -1;
        if (finish_tile(j, &j->slots[first ? 0 : (turn + 1) & 1], first, error) < 0)
            return -1;
        turn++;
        stop = progress ? progress(user, (double)j->done / all) : 0;
    }
    for (int i = 0; i < 2; i++)
        if (finish_tile(j, &j->slots[(turn + i) & 1], false, error) < 0)
            return -1;
    if (stop && (double)j->done < all)
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

static int prepare(job *j, const feeler_scene *scene, feeler_error *error) {
    const feeler_settings *s = &j->settings;
    if (pack_scene(&j->packed, scene, s->level == FEELER_REFERENCE, s->brute_force, error) < 0)
        return -1;
    j->features = s->general ? ((UINT32_C(1) << FEATURE_COUNT) - 1) : j->packed.features;
    j->media = s->general ? 8 : j->packed.media;
    if (s->general && s->brute_force)
        j->features &= ~(UINT32_C(1) << FEATURE_TREE);
    const view view = pack_view(scene, s, j->packed.origin);
    if (choose_work_group(j->device, s, j->features, j->media, j->group, error) < 0)
        return -1;
    if (upload_scene(&j->upload, &j->packed, &view, j->media, j->device, error) < 0)
        return -1;
    char *options = program_options(s, j->features, j->media, error);
    int status = options ? program_build(&j->program, j->device, options, error) : -1;
    free(options);
    if (status < 0)
        return -1;
    j->slot_pixels = slot_room(j);
    for (int i = 0; i < 2; i++)
        if (open_slot(j, &j->slots[i], error) < 0)
            return -1;
    tiles_start(&j->tiles, s->region, j->group, first_budget(j));
    bool transmits = j->features >> FEATURE_TRANSMISSION & 1;
    return transmits ? find_eye_media(j, error) : 0;
}

static void list_features(uint32_t features, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < FEATURE_COUNT; i++)
        if (features >> i & 1)
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? " " : "", feature_names[i]);
    for (char *c = text; *c; c++)
        *c = (char)tolower((unsigned char)*c);
}

static int fill_stats(job *j, const feeler_scene *scene, double start, feeler_error *error) {
    render_stats *stats = &j->image->stats;
    double *lights = malloc((2 * scene->light_count + 1) * sizeof *lights);
    if (!lights)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    stats->truncation_bound = truncation_bound(scene, j->discarded, lights);
    free(lights);
    stats->load = scene->load_seconds;
    stats->tree = j->packed.tree_seconds;
    stats->compile += j->program.seconds;
    stats->total = stats->load + seconds_now() - start;
    stats->discarded_max = fmax(j->discarded[0], fmax(j->discarded[1], j->discarded[2]));
    stats->discarded_mean = j->done ? j->discarded_sum / (double)j->done : 0;
    snprintf(stats->device, sizeof stats->device, "%s", j->device->name);
    memcpy(stats->work_group, j->group, sizeof j->group);
    stats->level = j->settings.level;
    stats->lanes = j->settings.lanes;
    stats->width = j->settings.width;
    stats->height = j->settings.height;
    stats->samples = j->settings.samples;
    stats->depth = j->settings.depth;
    stats->jitter = j->settings.jitter;
    stats->cutoff = j->settings.cutoff;
    list_features(j->features, stats->features, sizeof stats->features);
    return 0;
}

feeler_image *feeler_render(const feeler_scene *scene, const feeler_settings *settings, feeler_device *device,
                            feeler_progress progress, void *user, feeler_error *error) {
    double start = seconds_now();
    job j = {.device = device};
    int status = resolve_settings(scene, settings, &j.settings, error);
    if (status == 0 && j.settings.level == FEELER_REFERENCE && !device->has_double)
        status = fail(error, FEELER_DEVICE, "'%s' has no double precision, which level reference needs", device->name);
    if (status == 0)
        status = prepare(&j, scene, error);
    if (status == 0)
        status = (j.image = new_image(&j, scene, error)) ? 0 : -1;
    if (status == 0)
        status = run_tiles(&j, progress, user, error);
    if (status == 0)
        status = fill_stats(&j, scene, start, error);
    if (status < 0) {
        /* Nothing may still write to what is about to be freed. */
        clFinish(device->queue);
        feeler_image_free(j.image);
        j.image = NULL;
    }
    for (int i = 0; i < 2; i++)
        close_slot(&j.slots[i]);
    program_free(&j.program);
    upload_free(&j.upload);
    packed_free(&j.packed);
    return j.image;
}
