/* image_plugin.c - loads the part that reads and writes files when it is first needed, or beside what a render does before:
 * OpenImageIO and what it pulls in take a quarter of a second to load, which no other command should wait for. */
#define _GNU_SOURCE
#include "image.h"
#include "scene.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

typedef int (*writer)(const feeler_image *, const char *, const char *, const feeler_save_options *, feeler_error *);
typedef int (*reader)(feeler_image *, const char *, feeler_error *);

/* What OpenImageIO pulls in, each library after those that it needs. */
static const char *const libraries[] = {
#include "image_libraries.h"
    NULL};

enum { UNKNOWN, LOADED, MISSING };
static pthread_mutex_t loading = PTHREAD_MUTEX_INITIALIZER; /* held by who loads */
static atomic_int known;                                    /* set when what follows is */
static writer write_image;
static reader read_image;
static char why[512];

static struct {
    pthread_t thread;
    bool started;
    atomic_bool stop;
} ahead;

/* Where a library is loaded by itself, its symbols are looked for in the few that it needs; where all are loaded at once,
 * in all 250. What cannot be loaded alone is loaded with the whole. */
static void load_one_by_one(const atomic_bool *stop) {
    for (size_t i = 0; libraries[i] && !(stop && *stop); i++)
        (void)dlopen(libraries[i], RTLD_LAZY | RTLD_LOCAL);
}

/* Beside this library, wherever that was loaded from. */
static void load_whole(void) {
    static const char name[] = "libfeeler-image.so";
    char path[PATH_MAX];
    Dl_info here;
    if (!dladdr((void *)(uintptr_t)feeler_version, &here) || !here.dli_fname)
        here.dli_fname = "";
    const char *slash = strrchr(here.dli_fname, '/');
    int folder = slash ? (int)(slash + 1 - here.dli_fname) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, here.dli_fname, name);
    void *library = dlopen(path, RTLD_LAZY | RTLD_LOCAL);
    void *writes = library ? dlsym(library, "feeler_image_io_write") : NULL;
    void *reads = writes ? dlsym(library, "feeler_image_io_read") : NULL;
    if (reads) { /* ISO C has no cast from object to function */
        memcpy(&write_image, &writes, sizeof write_image);
        memcpy(&read_image, &reads, sizeof read_image);
    } else {
        const char *reason = dlerror();
        snprintf(why, sizeof why, "%.500s", reason ? reason : path);
    }
    known = reads ? LOADED : MISSING;
}

/* Waits for another thread that is at it. */
static void load(const atomic_bool *stop) {
    pthread_mutex_lock(&loading);
    if (known == UNKNOWN)
        load_one_by_one(stop);
    if (known == UNKNOWN && !(stop && *stop))
        load_whole();
    pthread_mutex_unlock(&loading);
}

static void *load_ahead(void *unused) {
    load(&ahead.stop);
    return unused;
}

int image_io_known(const char *path, feeler_error *error) {
    return known == MISSING ? fail(error, FEELER_IO, "%s: cannot write pictures: %s", path, why) : 0;
}

int feeler_image_load_begin(const char *path, feeler_error *error) {
    if (known == UNKNOWN && !ahead.started) {
        ahead.stop = false;
        /* Without a thread it is loaded when it is needed. */
        ahead.started = pthread_create(&ahead.thread, NULL, load_ahead, NULL) == 0;
    }
    return image_io_known(path, error);
}

void feeler_image_load_end(void) {
    if (!ahead.started)
        return;
    ahead.stop = true;
    (void)pthread_join(ahead.thread, NULL);
    ahead.started = false;
}

int image_io_write(const feeler_image *image, const char *path, const char *format_name,
                   const feeler_save_options *options, feeler_error *error) {
    load(NULL);
    return image_io_known(format_name, error) < 0 ? -1 : write_image(image, path, format_name, options, error);
}

int image_io_read(feeler_image *image, const char *path, feeler_error *error) {
    load(NULL);
    return known == MISSING ? fail(error, FEELER_IO, "%s: cannot read pictures: %s", path, why)
                            : read_image(image, path, error);
}
