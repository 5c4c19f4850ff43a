/* image_plugin.c - loads the part that writes files when it is first needed: OpenImageIO and what it pulls in take a
 * quarter of a second to load, which no other command should wait for. */
#define _GNU_SOURCE
#include "image.h"
#include "scene.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

typedef int (*writer)(const feeler_image *, const char *, const char *, const feeler_save_options *, feeler_error *);

static pthread_once_t once = PTHREAD_ONCE_INIT;
static writer write_image;
static char why[512];

/* Beside this library, wherever that was loaded from. */
static void load(void) {
    static const char name[] = "libfeeler-image.so";
    char path[PATH_MAX];
    Dl_info here;
    if (!dladdr((void *)(uintptr_t)feeler_version, &here) || !here.dli_fname)
        here.dli_fname = "";
    const char *slash = strrchr(here.dli_fname, '/');
    int folder = slash ? (int)(slash + 1 - here.dli_fname) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, here.dli_fname, name);
    void *library = dlopen(path, RTLD_LAZY | RTLD_LOCAL);
    void *symbol = library ? dlsym(library, "feeler_image_io_write") : NULL;
    if (symbol)
        memcpy(&write_image, &symbol, sizeof write_image); /* ISO C has no cast from object to function */
    else {
        const char *reason = dlerror();
        snprintf(why, sizeof why, "%.500s", reason ? reason : path);
    }
}

int image_io_ready(const char *path, feeler_error *error) {
    pthread_once(&once, load);
    return write_image ? 0 : fail(error, FEELER_IO, "%s: cannot write pictures: %s", path, why);
}

int image_io_write(const feeler_image *image, const char *path, const char *format_name,
                   const feeler_save_options *options, feeler_error *error) {
    if (image_io_ready(format_name, error))
        return -1;
    return write_image(image, path, format_name, options, error);
}
