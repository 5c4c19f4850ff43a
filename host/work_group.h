/* work_group.h - how many work-items a work group has. */
#ifndef FEELER_WORK_GROUP_H
#define FEELER_WORK_GROUP_H

#include "program.h"

/* Given by the caller; given though it may crash; kept by the user for this device and kernel; or chosen here. */
typedef enum group_origin { GROUP_GIVEN, GROUP_FORCED, GROUP_TUNED, GROUP_CHOSEN } group_origin;

extern const char *const group_origin_names[];

/* The work group to use for the kernels that these options build: the one asked for, if device and kernel can; else one that is kept and safe; else one whose
 * stacks stay near the cache. */
int choose_work_group(const feeler_device *device, const program *program, const feeler_settings *resolved, needs needs,
                      const char *options, int work_group[2], group_origin *from, feeler_error *error);

#endif
