/* launch.c - what a render asks of the device: buffers, arguments, launches. */
#include "clock.h"
#include "job.h"

#include <stdlib.h>

size_t real_size(const job *j) {
    return j->settings.level == FEELER_REFERENCE ? sizeof(double) : sizeof(float);
}

/* The device's memory is this, where it shares the host's: then nothing is copied when results are read. */
static int open_result(const job *j, result *r, size_t pixel, feeler_error *error) {
    const size_t page = 4096, size = (j->slot_pixels * pixel + page - 1) / page * page;
    r->pixel = pixel;
    r->host = aligned_alloc(page, size);
    if (!r->host)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for a tile of %zu pixels", j->slot_pixels);
    cl_int status;
    r->buffer = clCreateBuffer(j->device->context, CL_MEM_WRITE_ONLY | CL_MEM_USE_HOST_PTR, size, r->host, &status);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clCreateBuffer", status);
}

int open_slot(const job *j, slot *s, feeler_error *error) {
    const size_t colour = 4 * real_size(j),
                 of[RESULTS] = {colour, sizeof(uint4), colour, 2 * colour, 2 * sizeof(cl_int)};
    for (int i = 0; i < (j->survey.program ? RESULTS : RESULT_SURFACES); i++)
        if (open_result(j, &s->results[i], of[i], error) < 0)
            return -1;
    return 0;
}

static void release_event(cl_event *event) {
    if (*event)
        clReleaseEvent(*event);
    *event = NULL;
}

void release_events(slot *s) {
    release_event(&s->launched);
    release_event(&s->surveyed);
    release_event(&s->read);
}

void close_slot(slot *s) {
    release_events(s);
    for (int i = 0; i < RESULTS; i++) {
        if (s->results[i].buffer)
            clReleaseMemObject(s->results[i].buffer);
        free(s->results[i].host);
    }
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
    return (launch){
        .tile = {(uint32_t)t->x0, (uint32_t)t->y0, (uint32_t)t->x1, (uint32_t)t->y1},
        .frame = {(uint32_t)j->settings.width, (uint32_t)j->settings.height, (uint32_t)j->settings.samples,
                  (uint32_t)j->settings.depth},
        .count = {(uint32_t)arrays[ARRAY_LIGHTS].count, (uint32_t)j->packed.own_blocks,
                  (uint32_t)arrays[ARRAY_NODES].count, (uint32_t)j->packed.planes},
    };
}

int clear_eye_media(const job *j, feeler_error *error) {
    cl_int none[MOST_MEDIA];
    for (int i = 0; i < MOST_MEDIA; i++)
        none[i] = -1;
    size_t size = (size_t)j->needs.media * sizeof *none;
    cl_int status = clEnqueueWriteBuffer(j->device->queue, j->upload.eye_media, CL_TRUE, 0, size, none, 0, NULL, NULL);
    if (status == CL_SUCCESS)
        status = clFinish(j->device->queue); /* as upload_view does */
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueWriteBuffer", status);
}

/* One work-item; waits for it. */
static int run_alone(const job *j, cl_kernel kernel, feeler_error *error) {
    const size_t one = 1;
    cl_int status = clEnqueueNDRangeKernel(j->device->queue, kernel, 1, NULL, &one, &one, 0, NULL, NULL);
    if (status == CL_SUCCESS)
        status = clFinish(j->device->queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueNDRangeKernel", status);
}

int find_eye_media(const job *j, feeler_error *error) {
    cl_int status = CL_SUCCESS;
    cl_kernel kernel = j->program.find_eye_media;
    const launch frame = make_launch(j, &(tile){0, 0, 0, 0});
    cl_uint i = bind_scene(kernel, &j->upload, &status);
    status |= clSetKernelArg(kernel, i++, sizeof frame, &frame);
    status |= clSetKernelArg(kernel, i, sizeof(cl_mem), &j->upload.eye_media);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clSetKernelArg", status);
    return run_alone(j, kernel, error);
}

int bind_frame(const job *j, const slot *s, cl_kernel kernel, int first, int end, feeler_error *error) {
    cl_int status = CL_SUCCESS;
    const launch frame = make_launch(j, &s->tile);
    cl_uint i = bind_scene(kernel, &j->upload, &status);
    status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &j->upload.eye_media);
    status |= clSetKernelArg(kernel, i++, sizeof frame, &frame);
    for (int k = first; k < end; k++)
        status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &s->results[k].buffer);
    return status == CL_SUCCESS ? (int)i : fail_cl(error, "clSetKernelArg", status);
}

bool sends_rays(const job *j) {
    return j->needs.features & (1u << FEATURE_REFLECTION | 1u << FEATURE_TRANSMISSION);
}

size_t tile_pixels(const tile *t) {
    return (size_t)(t->x1 - t->x0) * (size_t)(t->y1 - t->y0);
}

static size_t round_up(int length, int by) {
    return (size_t)((length + by - 1) / by) * (size_t)by;
}

/* Work-items for a side of so many pixels. */
static int items(int length, int pixels) {
    return (length + pixels - 1) / pixels;
}

int enqueue_tile(const job *j, const slot *s, cl_kernel kernel, const int pixels[2], const int group[2],
                 cl_event *after, cl_event *event, feeler_error *error) {
    const tile *t = &s->tile;
    const size_t local[2] = {(size_t)group[0], (size_t)group[1]};
    const size_t global[2] = {round_up(items(t->x1 - t->x0, pixels[0]), group[0]),
                              round_up(items(t->y1 - t->y0, pixels[1]), group[1])};
    cl_int status =
        clEnqueueNDRangeKernel(j->device->queue, kernel, 2, NULL, global, local, after ? 1 : 0, after, event);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueNDRangeKernel", status);
}

static bool has_result(const job *j, int result) {
    return result < RESULT_UNSENT || (result == RESULT_UNSENT ? sends_rays(j) : j->survey.program != NULL);
}

static cl_event *last_launched(slot *s) {
    return s->surveyed ? &s->surveyed : &s->launched;
}

/* One after another, whatever order the queue keeps: the last one's event tells that all are there. */
static int read_results(const job *j, slot *s, feeler_error *error) {
    cl_int status = CL_SUCCESS;
    for (int i = 0; i < RESULTS && status == CL_SUCCESS; i++) {
        const result *r = &s->results[i];
        if (!has_result(j, i))
            continue;
        cl_event before = s->read;
        s->read = NULL;
        status = clEnqueueReadBuffer(j->device->queue, r->buffer, CL_FALSE, 0, tile_pixels(&s->tile) * r->pixel,
                                     r->host, 1, before ? &before : last_launched(s), &s->read);
        release_event(&before);
    }
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueReadBuffer", status);
}

int start_tile(const job *j, slot *s, const tile *t, feeler_error *error) {
    cl_command_queue queue = j->device->queue;
    s->tile = *t;
    s->start = seconds_now();
    cl_kernel render = j->program.render;
    if (bind_frame(j, s, render, RESULT_PIXELS, RESULT_SURFACES, error) < 0 ||
        enqueue_tile(j, s, render, j->settings.pixels, j->group, NULL, &s->launched, error) < 0)
        return -1;
    if ((j->survey.program && start_survey(j, s, error) < 0) || read_results(j, s, error) < 0)
        return -1;
    cl_int status = clFlush(queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clFlush", status);
}

int launch_notes(const job *j, const cl_mem *buffers, size_t count, uint4 room, cl_mem counts, feeler_error *error) {
    const int *r = j->settings.region;
    slot s = j->slots[0];
    s.tile = (tile){r[0], r[1], r[2], r[3]};
    const int first = bind_frame(j, &s, j->program.render, RESULT_PIXELS, RESULT_SURFACES, error);
    if (first < 0)
        return -1;
    cl_kernel kernel = j->program.render;
    cl_int status = CL_SUCCESS;
    cl_uint i = (cl_uint)first;
    for (size_t k = 0; k < count; k++)
        status |= clSetKernelArg(kernel, i++, sizeof(cl_mem), &buffers[k]);
    status |= clSetKernelArg(kernel, i++, sizeof room, &room);
    status |= clSetKernelArg(kernel, i, sizeof(cl_mem), &counts);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clSetKernelArg", status);
    return run_alone(j, kernel, error);
}

double launch_seconds(job *j, const slot *s) {
    cl_ulong start, end;
    if (clGetEventProfilingInfo(s->launched, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(s->surveyed ? s->surveyed : s->launched, CL_PROFILING_COMMAND_END, sizeof end, &end,
                                NULL) != CL_SUCCESS)
        return -1;
    if (start < j->launch_end)
        start = j->launch_end;
    if (end < start)
        end = start;
    j->launch_end = end;
    return 1e-9 * (double)(end - start);
}
