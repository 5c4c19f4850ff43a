/* progress.h - a render that can be watched and stopped. */
#ifndef FEELER_PROGRESS_H
#define FEELER_PROGRESS_H

#include <stdbool.h>

typedef struct progress {
    const char *name; /* what is rendered; borrowed */
    bool shown;
    bool drawn;         /* a line is on the screen */
    bool under_way;     /* it went on after some of the picture was there */
    double start, last; /* seconds */
} progress;

/* From here on the first SIGINT or SIGTERM only raises a flag; the second ends the program at once. */
void progress_catch_signals(void);
bool progress_interrupted(void);

/* Draws only where `shown` and stderr is a terminal. */
void progress_begin(progress *progress, const char *name, bool shown);
/* A feeler_progress whose `user` is a progress. */
int progress_step(void *user, double fraction);
/* Takes the line off the screen. */
void progress_end(progress *progress);

#endif
