/* tuned.h - the work groups that a user's `feeler bench --save` found best, each for one device and one kernel. */
#ifndef FEELER_TUNED_H
#define FEELER_TUNED_H

#include <jansson.h>
#include <stdbool.h>

/* The work group that is kept for this device and the kernels that these options build; false: none is, or the file
 * cannot be used. */
bool tuned_find(const char *device, const char *options, int work_group[2]);

/* {"file": path, "work_groups": {device: [x, y], …}} for the devices that have one for these options, {} where there are
 * none; NULL: out of memory. */
json_t *tuned_json(const char *options);

#endif
