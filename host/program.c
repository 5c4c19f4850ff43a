/* program.c - builds the kernels. Their source is one string in the library; options decide precision, lanes, features. */
#include "program.h"

#include "clock.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const unsigned char feeler_kernel_text[];

const char *feeler_kernel_source(void) {
    return (const char *)feeler_kernel_text;
}

void feeler_free(void *memory) {
    free(memory);
}

static bool has(uint32_t features, feature feature) {
    return features >> feature & 1;
}

/* The least power of two that holds a waiting ray for every depth: few sizes, so that few kernels are built. */
static int stack_size(const feeler_settings *s) {
    int size = 4;
    while (size < s->depth)
        size *= 2;
    return size;
}

size_t work_item_bytes(const feeler_settings *s, needs n) {
    size_t lane = s->level == FEELER_REFERENCE ? 8 : 4;
    size_t packet = (size_t)(10 + (has(n.features, FEATURE_TRANSMISSION) ? n.media : 0)) * lane * (size_t)s->lanes + 64;
    bool stacks = has(n.features, FEATURE_REFLECTION) && has(n.features, FEATURE_TRANSMISSION);
    return packet * (size_t)(stacks ? stack_size(s) + 4 : 4);
}

/* Writes " -DHAS_NAME=0" or 1 for a feature. */
static size_t print_feature(char *text, size_t size, feature feature, bool on) {
    char name[64];
    size_t length = 0;
    for (; feature_names[feature][length] && length + 1 < sizeof name; length++)
        name[length] = (char)toupper((unsigned char)feature_names[feature][length]);
    name[length] = '\0';
    return (size_t)snprintf(text, size, " -DHAS_%s=%d", name, on);
}

char *program_options(const feeler_settings *s, needs n, feeler_error *error) {
    const char *extra = getenv("FEELER_KERNEL_OPTIONS");
    size_t size = 1024 + FEATURE_COUNT * 80 + (extra ? strlen(extra) : 0), used;
    char *text = malloc(size);
    if (!text) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the kernel's options");
        return NULL;
    }
    const int eyes = s->samples * s->pixels[0] * s->pixels[1], rays = eyes > 1 ? s->lanes : 1;
    used = (size_t)snprintf(
        text, size,
        "-cl-std=CL1.2 -DLANES=%d -DRAYS=%d -DPIXELS_X=%d -DPIXELS_Y=%d -DONE_PACKET=%d -DSTACK=%d -DMEDIA=%d",
        s->lanes, rays, s->pixels[0], s->pixels[1], eyes <= rays && !n.notes, stack_size(s), n.media);
    if (n.width != WIDTH)
        used += (size_t)snprintf(text + used, size - used, " -DWIDTH=%d", n.width);
    if (s->level == FEELER_REFERENCE)
        used += (size_t)snprintf(text + used, size - used, " -DDOUBLE");
    if (s->level == FEELER_DRAFT)
        used += (size_t)snprintf(text + used, size - used, " -DDRAFT");
    if (n.notes)
        used += (size_t)snprintf(text + used, size - used, " -DRECORD=1");
    for (int i = 0; i < FEATURE_COUNT; i++)
        used += print_feature(text + used, size - used, (feature)i, has(n.features, (feature)i));
    if (extra)
        snprintf(text + used, size - used, " %s", extra);
    return text;
}

char *feeler_kernel_options(const feeler_scene *scene, const feeler_settings *settings, feeler_error *error) {
    feeler_settings s = *settings;
    needs n = {all_features, MOST_MEDIA, WIDTH, false};
    if (!scene) {
        s.lanes = s.lanes ? s.lanes : 1;
        s.depth = s.depth ? s.depth : 16;
        s.pixels[0] = s.pixels[1] = 1;
    } else {
        if (resolve_settings(scene, settings, &s, error) < 0)
            return NULL;
        n = choose_needs(scene, &s);
    }
    return program_options(&s, n, error);
}

/* The first error of a build log as the message, the log whole beside it. */
static int fail_build(feeler_error *error, cl_program program, cl_device_id device, cl_int status) {
    size_t size = 0;
    char *log = NULL;
    if (clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) == CL_SUCCESS)
        log = malloc(size + 1);
    if (!log || clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log, NULL) != CL_SUCCESS) {
        free(log);
        return fail_cl(error, "clBuildProgram", status);
    }
    log[size] = '\0';
    const char *first = strstr(log, "error:");
    int length = first ? (int)strcspn(first + 6, "\n") : 0;
    fail(error, FEELER_DEVICE, "the kernels do not build:%.*s", length, first ? first + 6 : "");
    snprintf(error->log, sizeof error->log, "%s", log);
    free(log);
    return -1;
}

/* The error bounds of hit points count on it; a device that cannot is off by up to 3 ulp (OpenCL 1.2, 7.4). */
static bool rounds_correctly(const feeler_device *device) {
    cl_device_fp_config config = 0;
    return clGetDeviceInfo(device->id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof config, &config, NULL) == CL_SUCCESS &&
           (config & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT);
}

static cl_program build(const feeler_device *device, const char *options, feeler_error *error) {
    static const char rounded[] = " -cl-fp32-correctly-rounded-divide-sqrt";
    cl_int status;
    const char *source = feeler_kernel_source();
    char *exact = malloc(strlen(options) + sizeof rounded);
    if (!exact) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the kernel's options");
        return NULL;
    }
    strcat(strcpy(exact, options), rounds_correctly(device) ? rounded : "");
    cl_program program = clCreateProgramWithSource(device->context, 1, &source, NULL, &status);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clCreateProgramWithSource", status);
        free(exact);
        return NULL;
    }
    status = clBuildProgram(program, 1, &device->id, exact, NULL, NULL);
    free(exact);
    if (status == CL_SUCCESS)
        return program;
    fail_build(error, program, device->id, status);
    clReleaseProgram(program);
    return NULL;
}

/* Puts a program in the place of the oldest. Without memory for its options it is not kept, which only costs time. */
static void keep(feeler_device *device, const char *options, cl_program program) {
    built *place = &device->built[device->next_built];
    char *copy = strdup(options);
    if (!copy || clRetainProgram(program) != CL_SUCCESS) {
        free(copy);
        return;
    }
    if (place->program)
        (void)clReleaseProgram(place->program);
    free(place->options);
    *place = (built){copy, program};
    device->next_built = (device->next_built + 1) % MOST_BUILT;
}

static cl_program find_kept(const feeler_device *device, const char *options) {
    for (int i = 0; i < MOST_BUILT; i++) {
        const built *b = &device->built[i];
        if (b->options && strcmp(b->options, options) == 0 && clRetainProgram(b->program) == CL_SUCCESS)
            return b->program;
    }
    return NULL;
}

int program_build(program *p, feeler_device *device, const char *options, const char *entry, feeler_error *error) {
    double start = seconds_now();
    cl_int status;
    memset(p, 0, sizeof *p);
    p->program = find_kept(device, options);
    if (!p->program) {
        p->program = build(device, options, error);
        if (!p->program)
            return -1;
        keep(device, options, p->program);
    }
    p->render = clCreateKernel(p->program, entry, &status);
    if (status == CL_SUCCESS && strcmp(entry, "survey") != 0)
        p->find_eye_media = clCreateKernel(p->program, "find_eye_media", &status);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clCreateKernel", status);
        program_free(p);
        return -1;
    }
    p->seconds = seconds_now() - start;
    return 0;
}

void program_free(program *p) {
    if (p->render)
        clReleaseKernel(p->render);
    if (p->find_eye_media)
        clReleaseKernel(p->find_eye_media);
    if (p->program)
        clReleaseProgram(p->program);
    memset(p, 0, sizeof *p);
}
