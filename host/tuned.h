/* tuned.h - the work groups that a user's `feeler bench --save` found best, each for one device and one kernel. */
#ifndef FEELER_TUNED_H
#define FEELER_TUNED_H

#include "packed.h"

#include <jansson.h>

/* The work group that is kept for this device and kernel; false: none is, or the file cannot be used. */
bool tuned_find(const char *device, const feeler_settings *resolved, needs needs, int work_group[2]);

/* {"file": path, "work_groups": {device: [x, y], …}} for the devices that this kernel is kept for, {} where there are
 * none; NULL: out of memory. */
json_t *tuned_json(const feeler_settings *resolved, needs needs);

#endif
