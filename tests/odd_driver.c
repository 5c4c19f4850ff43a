/* odd_driver.c - preloaded, makes an OpenCL driver that is wrong for groups two wide, whose work-items count from 1, that
 * tells a microsecond for every launch of groups sixteen wide, and that crashes at groups three wide. For processes that use
 * groups of one size. */
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

typedef cl_int (*enqueue_call)(cl_command_queue, cl_kernel, cl_uint, const size_t *, const size_t *, const size_t *,
                               cl_uint, const cl_event *, cl_event *);
typedef cl_int (*profile_call)(cl_event, cl_profiling_info, size_t, void *, size_t *);

static size_t width; /* of the last group */

static void find_next(const char *name, void *function) {
    void *symbol = dlsym(RTLD_NEXT, name);
    if (!symbol)
        abort();
    memcpy(function, &symbol, sizeof symbol);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                              const size_t *global, const size_t *local, cl_uint count, const cl_event *before,
                              cl_event *event) {
    static const size_t one[3] = {1, 1, 1};
    enqueue_call next;
    find_next("clEnqueueNDRangeKernel", &next);
    width = local ? local[0] : 0;
    if (width == 3)
        raise(SIGSEGV);
    return next(queue, kernel, dimensions, width == 2 ? one : offset, global, local, count, before, event);
}

cl_int clGetEventProfilingInfo(cl_event event, cl_profiling_info what, size_t size, void *value, size_t *length) {
    profile_call next;
    find_next("clGetEventProfilingInfo", &next);
    if (width != 16 || what != CL_PROFILING_COMMAND_END)
        return next(event, what, size, value, length);
    cl_int status = next(event, CL_PROFILING_COMMAND_START, size, value, length);
    *(cl_ulong *)value += 1000;
    return status;
}
