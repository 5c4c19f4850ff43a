/* replacement.c */
#define _XOPEN_SOURCE 700 /* realpath */

#include "replacement.h"

#include "scene.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *target_of(const replacement *r) {
    return r->target ? r->target : r->path;
}

/* A new, empty file in the target's folder. Fills r->temporary; returns its descriptor or -1. */
static int open_temporary(replacement *r, feeler_error *error) {
    struct stat old;
    const char *target = target_of(r), *slash = strrchr(target, '/');
    int folder_length = slash ? (int)(slash - target + 1) : 0;
    for (int attempt = 0; attempt < 1000; attempt++) {
        int n = snprintf(r->temporary, sizeof r->temporary, "%.*s.feeler-%ld-%d.tmp", folder_length, target,
                         (long)getpid(), attempt);
        if (n < 0 || (size_t)n >= sizeof r->temporary)
            return fail(error, FEELER_IO, "%s: the name is too long", r->path);
        int file = open(r->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) {
            /* Where the mode cannot be kept, the umask's is good enough. */
            if (stat(target, &old) == 0)
                (void)fchmod(file, old.st_mode & 0777);
            return file;
        }
        if (errno != EEXIST)
            break;
    }
    return fail(error, FEELER_IO, "%s: cannot write: %s", r->path, strerror(errno));
}

int replacement_open(replacement *r, const char *path, feeler_error *error) {
    struct stat info;
    *r = (replacement){.path = path};
    /* A link stays a link: what it leads to is replaced. */
    if (lstat(path, &info) == 0 && S_ISLNK(info.st_mode))
        r->target = realpath(path, NULL);
    r->file = open_temporary(r, error);
    if (r->file >= 0)
        return 0;
    free(r->target);
    return -1;
}

int replacement_close(replacement *r, int status, feeler_error *error) {
    if (status == 0 && fsync(r->file))
        status = fail(error, FEELER_IO, "%s: cannot write: %s", r->path, strerror(errno));
    if (close(r->file) && status == 0)
        status = fail(error, FEELER_IO, "%s: cannot write: %s", r->path, strerror(errno));
    if (status == 0 && rename(r->temporary, target_of(r)))
        status = fail(error, FEELER_IO, "%s: cannot rename: %s", r->path, strerror(errno));
    if (status)
        (void)unlink(r->temporary);
    free(r->target);
    return status;
}
