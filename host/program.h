/* program.h - the kernels built for a scene and settings. */
#ifndef FEELER_PROGRAM_H
#define FEELER_PROGRAM_H

#include "device.h"
#include "packed.h"

typedef struct program {
    cl_program program;
    cl_kernel render;         /* or the entry point that was asked for in its place */
    cl_kernel find_eye_media; /* NULL for a survey (see survey.c) */
    double seconds;           /* to build; a device may compile more at the first launch */
} program;

/* Settings with every blank filled in from the scene, checked. */
int resolve_settings(const feeler_scene *scene, const feeler_settings *asked, feeler_settings *resolved,
                     feeler_error *error);

/* The build options for resolved settings and what a scene needs. To be freed. */
char *program_options(const feeler_settings *resolved, needs needs, feeler_error *error);

/* Builds, or takes what the device has built before. `entry`: "render"; "record_pixel" or "survey" for their options. */
int program_build(program *program, feeler_device *device, const char *options, const char *entry, feeler_error *error);
void program_free(program *program);

/* About how much of a CPU thread's stack one work-item takes, in bytes. */
size_t work_item_bytes(const feeler_settings *resolved, needs needs);

#endif
