/* upload.c */
#include "upload.h"

#include <stdlib.h>
#include <string.h>

enum { PIECE = 1 << 16 }; /* numbers that are narrowed at a time: a large scene is not held once more */

static cl_mem create_buffer(const feeler_device *device, const void *data, size_t size, feeler_error *error) {
    cl_int status;
    const cl_mem_flags copy = data ? CL_MEM_COPY_HOST_PTR : 0;
    cl_mem buffer = clCreateBuffer(device->context, CL_MEM_READ_ONLY | copy, size, (void *)data, &status);
    if (status == CL_SUCCESS)
        return buffer;
    fail_cl(error, "clCreateBuffer", status);
    if (error && (status == CL_MEM_OBJECT_ALLOCATION_FAILURE || status == CL_OUT_OF_HOST_MEMORY))
        error->code = FEELER_OUT_OF_MEMORY;
    return NULL;
}

/* OpenCL knows no empty buffer: what a scene lacks is one element of zeros, which lanes without a hit may read. */
static cl_mem copy_nothing(const feeler_device *device, feeler_error *error) {
    static const material nothing;
    return create_buffer(device, &nothing, sizeof nothing, error);
}

static cl_mem copy_narrowed(const feeler_device *device, const double *doubles, size_t count, feeler_error *error) {
    cl_mem buffer = create_buffer(device, NULL, count * sizeof(float), error);
    float *piece = malloc(PIECE * sizeof *piece);
    cl_int status = buffer && piece ? CL_SUCCESS : CL_OUT_OF_HOST_MEMORY;
    for (size_t i = 0, n; status == CL_SUCCESS && i < count; i += n) {
        n = count - i < PIECE ? count - i : PIECE;
        narrow(doubles + i, piece, n);
        status = clEnqueueWriteBuffer(device->queue, buffer, CL_TRUE, i * sizeof *piece, n * sizeof *piece, piece, 0,
                                      NULL, NULL);
    }
    free(piece);
    if (status == CL_SUCCESS)
        return buffer;
    if (buffer) {
        fail_cl(error, "clEnqueueWriteBuffer", status);
        clReleaseMemObject(buffer);
    }
    return NULL;
}

/* Reals go as the kernel's kind. */
static cl_mem copy_reals(const feeler_device *device, const double *reals, size_t count, bool is_double,
                         feeler_error *error) {
    return is_double ? create_buffer(device, reals, count * sizeof *reals, error)
                     : copy_narrowed(device, reals, count, error);
}

static cl_mem copy_array(const feeler_device *device, const array *a, bool is_double, feeler_error *error) {
    const size_t size = a->count * a->element;
    if (size == 0)
        return copy_nothing(device, error);
    return a->is_real ? copy_reals(device, a->data, size / sizeof(double), is_double, error)
                      : create_buffer(device, a->data, size, error);
}

int upload_scene(upload *u, packed *p, const feeler_device *device, feeler_error *error) {
    memset(u, 0, sizeof *u);
    for (int i = 0; i < ARRAY_COUNT; i++) {
        array *a = &p->arrays[i];
        u->arrays[i] = copy_array(device, a, p->is_double, error);
        if (!u->arrays[i]) {
            upload_free(u);
            return -1;
        }
        free(a->data);
        a->data = NULL;
    }
    return 0;
}

static void release_view(upload *u) {
    if (u->view)
        clReleaseMemObject(u->view);
    if (u->eye_media)
        clReleaseMemObject(u->eye_media);
    u->view = u->eye_media = NULL;
}

int upload_view(upload *u, const view *view, bool is_double, int media, const feeler_device *device,
                feeler_error *error) {
    release_view(u);
    u->view = copy_reals(device, (const double *)view, sizeof *view / sizeof(double), is_double, error);
    if (!u->view)
        return -1;
    cl_int status;
    u->eye_media = clCreateBuffer(device->context, CL_MEM_READ_WRITE, (size_t)media * sizeof(cl_int), NULL, &status);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clCreateBuffer", status);
    /* A blocking write has taken what it writes (OpenCL 1.2, 5.2.2); in a queue without order a launch may still overtake it. */
    status = clFinish(device->queue);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clFinish", status);
}

void upload_free(upload *u) {
    for (int i = 0; i < ARRAY_COUNT; i++)
        if (u->arrays[i])
            clReleaseMemObject(u->arrays[i]);
    release_view(u);
    memset(u, 0, sizeof *u);
}
