/* device.h - an OpenCL device with its context and queue. */
#ifndef FEELER_DEVICE_H
#define FEELER_DEVICE_H

#include "feeler.h"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <stdbool.h>

/* A program that was built before: rendering again with the same options need not ask the driver. */
typedef struct built {
    char *options; /* owned; NULL: an empty place */
    cl_program program;
} built;

enum { MOST_BUILT = 64 }; /* a chart of accuracy renders with some thirty in turn */

struct feeler_device {
    cl_context context;
    cl_device_id id;
    cl_command_queue queue; /* ours has profiling on; a caller's may not */
    char name[256];
    bool has_double;
    bool is_cpu;
    size_t max_work_group;
    built built[MOST_BUILT];
    int next_built; /* the place that the next one takes */
};

/* Fills the error with the call's name and OpenCL's name of the status; returns -1. */
int fail_cl(feeler_error *error, const char *call, cl_int status);

#endif
