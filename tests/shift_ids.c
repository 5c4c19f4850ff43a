/* shift_ids.c - preloaded, makes a driver that is wrong for groups two wide: their work-items count from 1. */
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

typedef cl_int (*enqueue)(cl_command_queue, cl_kernel, cl_uint, const size_t *, const size_t *, const size_t *, cl_uint,
                          const cl_event *, cl_event *);

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                              const size_t *global, const size_t *local, cl_uint count, const cl_event *before,
                              cl_event *event) {
    static const size_t one[3] = {1, 1, 1};
    void *symbol = dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel");
    enqueue next;
    if (!symbol)
        abort();
    memcpy(&next, &symbol, sizeof next);
    return next(queue, kernel, dimensions, local && local[0] == 2 ? one : offset, global, local, count, before, event);
}
