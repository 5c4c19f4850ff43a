/* job.h - a render under way. */
#ifndef FEELER_JOB_H
#define FEELER_JOB_H

#include "image.h"
#include "tiles.h"
#include "upload.h"
#include "work_group.h"

/* What a launch writes for each pixel: see render_pixels in render.cl; and where there is a survey, survey.cl. */
enum { RESULT_PIXELS, RESULT_RAYS, RESULT_UNSENT, RESULT_SURFACES, RESULT_IDS, RESULTS };

typedef struct result {
    cl_mem buffer;
    void *host;   /* what is read into; owned */
    size_t pixel; /* bytes */
} result;

/* A launch's results. Two take turns, so that the device never waits for the host. */
typedef struct slot {
    result results[RESULTS];
    cl_event launched, surveyed, read;
    tile tile;
    double start;
} slot;

typedef struct job {
    feeler_device *device;
    feeler_settings settings; /* resolved */
    bool notes;               /* of all that one pixel's rays do, instead of a picture: see record.h */
    needs needs;
    packed packed;
    upload upload;
    char *options; /* that the program is built with; owned until the image takes it */
    program program;
    program survey; /* nothing unless a channel needs it */
    int survey_group[2];
    slot slots[2];
    size_t slot_pixels; /* room in a slot */
    int group[2];
    group_origin group_from;
    tiles tiles;
    feeler_image *image;
    double discarded[3], discarded_sum; /* greatest per channel; sum over pixels of the greatest channel */
    bool stop;                          /* progress asked for it */
    cl_ulong launch_end;                /* of the last launch, by the device's clock */
    double taken;                       /* when the last tile was finished */
    size_t done;                        /* pixels */
} job;

/* A packed scene on its device, left by a render for others of the same scene, without channels. Zeroed: nothing. */
typedef struct resident {
    packed packed;
    upload upload;
} resident;

void resident_free(resident *resident);

/* Renders regions of one size, each into an image of its own, with one preparation; the first is that of the settings. How
 * many were made: fewer where `progress` asked to stop, which the error then says. -1: none. What is resident is used where it
 * has the precision and width of this render, and replaced where it does not; NULL: nothing is to stay. */
int render_regions(const feeler_scene *scene, const feeler_settings *settings, const int (*regions)[4], int count,
                   feeler_device *device, resident *resident, feeler_progress progress, void *user,
                   feeler_image **images, feeler_error *error);

/* Bytes of the kernels' `real`. */
size_t real_size(const job *job);
size_t tile_pixels(const tile *tile);
/* Whether rays are sent on at all: else no weight is unsent and the deepest level is 1. */
bool sends_rays(const job *job);

/* render.c: packs, uploads and builds for the resolved settings, until the first tile may start. What `progress` stops is
 * ready only in part. The job is to be closed in any case. */
int open_job(job *job, const feeler_scene *scene, feeler_progress progress, void *user, feeler_error *error);
void close_job(job *job);

/* survey.c: what lies beside the picture. All return 0, or -1 with the error filled. */
/* Room in the image for the channels that are asked for. */
int open_channels(job *job, const feeler_scene *scene, feeler_error *error);
/* Builds what the channels need beyond a render, if anything. */
int open_survey(job *job, feeler_error *error);
/* Launches a tile's survey, after its render. */
int start_survey(const job *job, slot *slot, feeler_error *error);
/* Takes a finished tile's channels into the image. */
void take_channels(job *job, const slot *slot);

/* launch.c: what is asked of the device. All return 0, or -1 with the error filled. */
int open_slot(const job *job, slot *slot, feeler_error *error);
void close_slot(slot *slot);
void release_events(slot *slot);
/* Finds the media that the eye is in, which takes a kernel to be compiled; waits for it. */
int find_eye_media(const job *job, feeler_error *error);
/* The eye is in none. */
int clear_eye_media(const job *job, feeler_error *error);
/* Sets the arguments of an entry point that computes a tile, its results being those from `first` to before `end`; the
 * index of the next, or -1. */
int bind_frame(const job *job, const slot *slot, cl_kernel kernel, int first, int end, feeler_error *error);
/* Launches a work-item for each block of `pixels` of the slot's tile, after an event or NULL. */
int enqueue_tile(const job *job, const slot *slot, cl_kernel kernel, const int pixels[2], const int group[2],
                 cl_event *after, cl_event *event, feeler_error *error);
/* Launches a tile and asks for its results; waits for nothing. */
int start_tile(const job *job, slot *slot, const tile *tile, feeler_error *error);
/* Launches the kernel that takes notes for the one pixel of the region, with these arguments besides the usual ones, and waits
 * for it. */
int launch_notes(const job *job, const cl_mem *buffers, size_t count, uint4 room, cl_mem counts, feeler_error *error);
/* How long the launch ran on the device after the one before it had ended; negative where the queue does not tell. To be
 * asked once for each, in their order. */
double launch_seconds(job *job, const slot *slot);

#endif
