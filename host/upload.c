/* upload.c */
#include "upload.h"

#include <stdlib.h>
#include <string.h>

/* OpenCL knows no empty buffer: what a scene lacks is one element of zeros, which lanes without a hit may read. */
static cl_mem copy_buffer(const feeler_device *device, const void *data, size_t size, feeler_error *error) {
    static const material nothing;
    cl_int status;
    if (!data) {
        data = &nothing;
        size = sizeof nothing;
    }
    cl_mem buffer =
        clCreateBuffer(device->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, size, (void *)data, &status);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clCreateBuffer", status);
        if (error && (status == CL_MEM_OBJECT_ALLOCATION_FAILURE || status == CL_OUT_OF_HOST_MEMORY))
            error->code = FEELER_OUT_OF_MEMORY;
        return NULL;
    }
    return buffer;
}

/* Reals go as the kernel's kind. */
static cl_mem copy_reals(const feeler_device *device, const void *doubles, size_t size, bool is_double,
                         feeler_error *error) {
    if (is_double || size == 0)
        return copy_buffer(device, size ? doubles : NULL, size, error);
    float *floats = narrow(doubles, size / sizeof(double), error);
    cl_mem buffer = floats ? copy_buffer(device, floats, size / 2, error) : NULL;
    free(floats);
    return buffer;
}

int upload_scene(upload *u, packed *p, const view *view, int media, const feeler_device *device, feeler_error *error) {
    memset(u, 0, sizeof *u);
    for (int i = 0; i < ARRAY_COUNT; i++) {
        array *a = &p->arrays[i];
        size_t size = a->count * a->element;
        u->arrays[i] = a->is_real ? copy_reals(device, a->data, size, p->is_double, error)
                                  : copy_buffer(device, size ? a->data : NULL, size, error);
        if (!u->arrays[i])
            goto failed;
        free(a->data);
        a->data = NULL;
    }
    u->view = copy_reals(device, view, sizeof *view, p->is_double, error);
    if (!u->view)
        goto failed;
    cl_int status;
    u->eye_media = clCreateBuffer(device->context, CL_MEM_READ_WRITE, (size_t)media * sizeof(cl_int), NULL, &status);
    if (status == CL_SUCCESS)
        return 0;
    fail_cl(error, "clCreateBuffer", status);
failed:
    upload_free(u);
    return -1;
}

void upload_free(upload *u) {
    for (int i = 0; i < ARRAY_COUNT; i++)
        if (u->arrays[i])
            clReleaseMemObject(u->arrays[i]);
    if (u->view)
        clReleaseMemObject(u->view);
    if (u->eye_media)
        clReleaseMemObject(u->eye_media);
    memset(u, 0, sizeof *u);
}
