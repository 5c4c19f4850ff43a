/* work_group.c */
#include "work_group.h"

#include "tuned.h"

#include <string.h>

const char *const group_origin_names[] = {"given", "forced", "tuned", "chosen"};

/* A CPU driver keeps the stacks of a whole group on one thread's stack: past about 8 MiB the process would crash. */
enum { CACHE_BYTES = 256 * 1024, MOST_STACK_BYTES = 4 * 1024 * 1024 };

typedef struct limits {
    const feeler_device *device;
    size_t most;  /* work-items that device and kernel allow */
    size_t bytes; /* of a CPU thread's stack that a work-item takes */
} limits;

static int find_limits(limits *l, const program *program, feeler_error *error) {
    const feeler_device *device = l->device;
    cl_int status = clGetKernelWorkGroupInfo(program->render, device->id, CL_KERNEL_WORK_GROUP_SIZE, sizeof l->most,
                                             &l->most, NULL);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clGetKernelWorkGroupInfo", status);
    if (l->most > device->max_work_group)
        l->most = device->max_work_group;
    return 0;
}

static int check_possible(const limits *l, const int group[2], feeler_error *error) {
    if ((size_t)group[0] * (size_t)group[1] > l->most)
        return fail(error, FEELER_BAD_USAGE,
                    "a work group of %d x %d: '%s' takes at most %zu work-items of this kernel", group[0], group[1],
                    l->device->name, l->most);
    return 0;
}

static int check_safe(const limits *l, const int group[2], feeler_error *error) {
    size_t bytes = (size_t)group[0] * (size_t)group[1] * l->bytes;
    if (l->device->is_cpu && bytes > MOST_STACK_BYTES)
        return fail(error, FEELER_BAD_USAGE,
                    "a work group of %d x %d needs %zu KiB of a thread's stack here; at most %d are safe", group[0],
                    group[1], bytes / 1024, MOST_STACK_BYTES / 1024);
    return 0;
}

static void choose(const limits *l, int group[2]) {
    group[0] = group[1] = 8;
    for (size_t items; (items = (size_t)(group[0] * group[1])) > 1;) {
        if (items <= l->most && !(l->device->is_cpu && items * l->bytes > CACHE_BYTES))
            return;
        group[group[0] > group[1] ? 0 : 1] /= 2;
    }
}

int choose_work_group(const feeler_device *device, const program *program, const feeler_settings *s, needs n,
                      const char *options, int group[2], group_origin *from, feeler_error *error) {
    limits l = {.device = device, .bytes = work_item_bytes(s, n)};
    if (find_limits(&l, program, error) < 0)
        return -1;
    memcpy(group, s->work_group, sizeof s->work_group);
    if (group[0]) {
        if (check_possible(&l, group, error) < 0)
            return -1;
        *from = s->unguarded && check_safe(&l, group, NULL) < 0 ? GROUP_FORCED : GROUP_GIVEN;
        return *from == GROUP_FORCED ? 0 : check_safe(&l, group, error);
    }
    *from = GROUP_TUNED;
    if (!s->untuned && tuned_find(device->name, options, group) && check_possible(&l, group, NULL) == 0 &&
        check_safe(&l, group, NULL) == 0)
        return 0;
    *from = GROUP_CHOSEN;
    choose(&l, group);
    return 0;
}
