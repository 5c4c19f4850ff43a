/* doctor.h - checks of the installation. */
#ifndef FEELER_DOCTOR_H
#define FEELER_DOCTOR_H

#include "feeler.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Checks the installation with the device that `select` means (as for feeler_device_open). Returns JSON text to be freed
 * with feeler_free: {"checks": [{"name", "state": "ok" | "warning" | "fail", "text", "mend"}]}; "mend" only where there is
 * something to mend. NULL only when out of memory: what is broken is in the text. */
FEELER_API char *feeler_doctor_json(const char *select, feeler_error *error);

#ifdef __cplusplus
}
#endif

#endif
