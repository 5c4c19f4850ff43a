/* launch.c - what a render asks of the device: buffers, arguments, launches. */
#include "clock.h"
#include "job.h"

#include <stdlib.h>

size_t real_size(const job *j) {
    return j->settings.level == FEELER_REFERENCE ? sizeof(double) : sizeof(float);
}

int open_slot(const job *j, slot *s, feeler_error *error) {
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

void close_slot(slot *s) {
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
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueWriteBuffer", status);
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
    const size_t one = 1;
    status = clEnqueueNDRangeKernel(j->device->queue, kernel, 1, NULL, &one, &one, 0, NULL, NULL);
    if (status == CL_SUCCESS)
        status = clFinish(j->device->queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueNDRangeKernel", status);
}

static int bind_render(const job *j, const slot *s, feeler_error *error) {
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

int start_tile(const job *j, slot *s, const tile *t, feeler_error *error) {
    cl_command_queue queue = j->device->queue;
    s->tile = *t;
    s->start = seconds_now();
    if (bind_render(j, s, error) < 0)
        return -1;
    const size_t local[2] = {(size_t)j->group[0], (size_t)j->group[1]}, count = tile_pixels(t);
    const int *pixels = j->settings.pixels;
    const size_t global[2] = {round_up(items(t->x1 - t->x0, pixels[0]), j->group[0]),
                              round_up(items(t->y1 - t->y0, pixels[1]), j->group[1])};
    cl_int status = clEnqueueNDRangeKernel(queue, j->program.render, 2, NULL, global, local, 0, NULL, &s->launched);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clEnqueueNDRangeKernel", status);
    const size_t colours = count * 4 * real_size(j);
    cl_event before[2] = {NULL, NULL}; /* one read after another, whatever order the queue keeps */
    status = clEnqueueReadBuffer(queue, s->pixels, CL_FALSE, 0, colours, s->host_pixels, 1, &s->launched, &before[0]);
    const bool sends = sends_rays(j);
    if (status == CL_SUCCESS && sends)
        status = clEnqueueReadBuffer(queue, s->discarded, CL_FALSE, 0, colours, s->host_discarded, 1, &before[0],
                                     &before[1]);
    if (status == CL_SUCCESS)
        status = clEnqueueReadBuffer(queue, s->tallies, CL_FALSE, 0, count * sizeof(tally), s->host_tallies, 1,
                                     &before[sends], &s->read);
    for (int i = 0; i < 2; i++)
        if (before[i])
            clReleaseEvent(before[i]);
    if (status == CL_SUCCESS)
        status = clFlush(queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueReadBuffer", status);
}

double launch_seconds(const slot *s) {
    cl_ulong start, end;
    if (clGetEventProfilingInfo(s->launched, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(s->launched, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) != CL_SUCCESS)
        return -1;
    return 1e-9 * (double)(end - start);
}
