/* record.h - notes of all that the rays of one pixel do, as the kernels take them (kernels/record.cl). */
#ifndef FEELER_RECORD_H
#define FEELER_RECORD_H

#include "job.h"

/* In double, whatever the kernel's precision; points relative to the packed scene's origin. */
typedef struct notes {
    uint4 count; /* rays, lights, crossings */
    ray_note *rays;
    ray_tags *ray_tags;
    light_note *lights; /* of one ray after another, in the order of the scene's */
    light_tags *light_tags;
    crossing_note *crossings;
    crossing_tags *crossing_tags;
    real4 pixel, unsent; /* what a render writes of the pixel: see render_pixels in render.cl */
    uint4 sent;
} notes;

/* Traces the one pixel of the job's region; the job is open and was opened for notes. */
int take_notes(const job *job, notes *notes, feeler_error *error);
void notes_free(notes *notes);

#endif
