/* upload.h - a packed scene on a device. */
#ifndef FEELER_UPLOAD_H
#define FEELER_UPLOAD_H

#include "device.h"
#include "packed.h"

typedef struct upload {
    cl_mem arrays[ARRAY_COUNT], view, eye_media;
} upload;

/* Copies the arrays. They keep their counts, but each one's data is freed when the device has it: a large scene is not held
 * twice. */
int upload_scene(upload *upload, packed *packed, const feeler_device *device, feeler_error *error);
/* Copies the view, in the place of another; the eye's media are room only, to be found by a kernel. */
int upload_view(upload *upload, const view *view, bool is_double, int media, const feeler_device *device,
                feeler_error *error);
void upload_free(upload *upload);

#endif
