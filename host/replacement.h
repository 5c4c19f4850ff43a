/* replacement.h - a file that takes another's place only when the whole of it is on the disk. */
#ifndef FEELER_REPLACEMENT_H
#define FEELER_REPLACEMENT_H

#include "feeler.h"

#include <limits.h>

typedef struct replacement {
    const char *path;         /* as the caller names it; borrowed */
    char *target;             /* owned; what a symbolic link leads to, else NULL */
    char temporary[PATH_MAX]; /* the hidden file that is written, in the target's folder */
    int file;                 /* its descriptor */
} replacement;

/* Makes the hidden file, with the mode of the file that it will replace, else that of the umask. */
int replacement_open(replacement *replacement, const char *path, feeler_error *error);
/* With status 0 gives the file its name, else removes it. Returns the status, or -1 when that failed. */
int replacement_close(replacement *replacement, int status, feeler_error *error);

#endif
