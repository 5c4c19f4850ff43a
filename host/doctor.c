/* doctor.c - checks the installation, one thing after another, and says how to mend what is broken. */
#include "doctor.h"

#include "device_list.h"
#include "doctor_arithmetic.h"
#include "image.h"
#include "scene.h"

#include <dirent.h>
#include <errno.h>
#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct report {
    json_t *checks;
    bool broken; /* out of memory */
} report;

/* `mend` NULL: nothing to mend. */
static void say(report *r, const char *state, const char *name, const char *mend, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

static void say(report *r, const char *state, const char *name, const char *mend, const char *format, ...) {
    char text[3072];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    json_t *content = json_string(text);
    for (char *c = text; !content && *c; c++) /* a driver's text may not be UTF-8 */
        if ((unsigned char)*c >= 0x80)
            *c = '?';
    if (!content)
        content = json_string(text);
    json_t *check = json_pack("{s:s, s:s, s:o}", "name", name, "state", state, "text", content);
    if (check && mend && json_object_set_new(check, "mend", json_string(mend)))
        r->broken = true;
    if (!check || json_array_append_new(r->checks, check))
        r->broken = true;
}

static void say_error(report *r, const char *name, const char *mend, const feeler_error *error) {
    char text[sizeof error->source + sizeof error->text + 64];
    feeler_error_format(error, text, sizeof text);
    say(r, "fail", name, mend, "%s%s%.900s", text, error->log[0] ? "\n" : "", error->log);
}

/* ---- OpenCL's loader and platforms ---- */

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

static void check_loader(report *r) {
    const char *folder = getenv("OCL_ICD_VENDORS");
    char names[512] = "";
    size_t used = 0;
    if (!folder || !*folder)
        folder = "/etc/OpenCL/vendors";
    if (ends_with(folder, ".icd") || ends_with(folder, ".so")) {
        say(r, "ok", "ICD loader", NULL, "OCL_ICD_VENDORS names one driver: %s", folder);
        return;
    }
    DIR *listing = opendir(folder);
    for (struct dirent *entry; listing && (entry = readdir(listing));)
        if (ends_with(entry->d_name, ".icd") && used < sizeof names - 1)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", entry->d_name);
    if (listing)
        closedir(listing);
    if (used)
        say(r, "ok", "ICD loader", NULL, "drivers in %s: %s", folder, names);
    else
        say(r, "warning", "ICD loader", "install a driver: apt install pocl-opencl-icd", "no drivers (.icd) in %s",
            folder);
}

static void check_platforms(report *r) {
    static const char install[] = "apt install pocl-opencl-icd; if it is installed, look at OCL_ICD_VENDORS and clinfo";
    feeler_error error = {0};
    device_list list;
    bool has_pocl = false;
    if (device_list_open(&list, &error)) {
        say_error(r, "platforms", install, &error);
        return;
    }
    for (size_t i = 0; i < list.count; i++) {
        const device_entry *entry = &list.entries[i];
        if (i > 0 && entry->platform == list.entries[i - 1].platform)
            continue;
        char version[256];
        platform_text(entry->platform, CL_PLATFORM_VERSION, version, sizeof version);
        say(r, "ok", "platform", NULL, "%s, %s", entry->platform_name, version);
        has_pocl = has_pocl || strcmp(entry->platform_name, "Portable Computing Language") == 0;
    }
    if (!has_pocl)
        say(r, "warning", "PoCL", "apt install pocl-opencl-icd",
            "the CPU's OpenCL, on which feeler is tested, is not among the platforms");
    device_list_close(&list);
}

/* ---- PoCL's cache ---- */

static void cache_folder(char *path, size_t size) {
    const char *own = getenv("POCL_CACHE_DIR"), *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (own && *own)
        snprintf(path, size, "%s", own);
    else if (cache && *cache)
        snprintf(path, size, "%s/pocl/kcache", cache);
    else if (home && *home)
        snprintf(path, size, "%s/.cache/pocl/kcache", home);
    else
        snprintf(path, size, "/tmp/pocl/kcache");
}

static void check_cache(report *r) {
    static const char mend[] = "set POCL_CACHE_DIR to a folder that you can write to";
    char folder[4096], existing[4096];
    cache_folder(folder, sizeof folder);
    strcpy(existing, folder);
    /* PoCL makes what is missing, so the nearest folder that exists is the one that counts. */
    while (access(existing, F_OK)) {
        char *slash = strrchr(existing, '/');
        if (!slash)
            strcpy(existing, ".");
        else
            slash[slash == existing] = '\0';
    }
    if (access(existing, W_OK | X_OK))
        say(r, "fail", "kernel cache", mend, "%s: cannot write: %s", folder, strerror(errno));
    else
        say(r, "ok", "kernel cache", NULL, "%s", folder);
    const char *method = getenv("POCL_WORK_GROUP_METHOD");
    if (method && *method)
        say(r, "warning", "PoCL setting", "unset POCL_WORK_GROUP_METHOD",
            "POCL_WORK_GROUP_METHOD=%s slows kernels down", method);
}

/* ---- OpenImageIO ---- */

static void check_formats(report *r) {
    static const char *const endings[] = {"exr", "hdr", "png", "tif", "jpg"};
    static const feeler_save_options plain;
    float pixels[4 * 4] = {0.25f, 0.5f, 0.75f, 1};
    feeler_image image = {.width = 2, .height = 2, .pixels = pixels, .stats = {.width = 2, .height = 2}};
    const char *base = getenv("TMPDIR");
    char folder[4096], path[4200], good[64] = "";
    snprintf(folder, sizeof folder, "%s/feeler-doctor-XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(folder)) {
        say(r, "warning", "OpenImageIO", "set TMPDIR to a folder that you can write to", "not tried: %s: %s", folder,
            strerror(errno));
        return;
    }
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        feeler_error error = {0};
        snprintf(path, sizeof path, "%s/try.%s", folder, endings[i]);
        if (image_io_write(&image, path, path, &plain, &error))
            say_error(r, "OpenImageIO", "install an OpenImageIO with this format: apt install libopenimageio-dev",
                      &error);
        else
            strcat(strcat(good, good[0] ? ", " : ""), endings[i]);
        (void)unlink(path);
    }
    (void)rmdir(folder);
    if (good[0])
        say(r, "ok", "OpenImageIO", NULL, "writes %s", good);
}

/* ---- the device ---- */

static void judge(report *r, const char *name, const arithmetic *a) {
    static const char other[] = "choose another device ('feeler devices') where exactness matters";
    if (a->wrong_divisions || a->wrong_roots)
        say(r, "warning", name, other, "division or square root is not correctly rounded (%d and %d of %d)",
            a->wrong_divisions, a->wrong_roots, a->count);
    else
        say(r, "ok", name, NULL, "division and square root are correctly rounded (%d values)", a->count);
    if (a->fused)
        say(r, "fail", name, other, "FP_CONTRACT OFF is ignored (%d of %d): pictures may depend on the work-group size",
            a->fused, a->count);
    else
        say(r, "ok", name, NULL, "FP_CONTRACT OFF is honoured");
    if (a->flushed)
        say(r, "warning", name, other, "denormal numbers are flushed to zero");
}

static void check_device(report *r, const char *select) {
    feeler_error error = {0};
    arithmetic a;
    feeler_device *device = feeler_device_open(select, &error);
    if (!device) {
        say_error(r, "device", "see 'feeler devices'", &error);
        return;
    }
    say(r, "ok", "device", NULL, "%s", device->name);
    if (arithmetic_try(device, false, &a, &error))
        say_error(r, "kernel", "the driver cannot build or run kernels: reinstall it; for PoCL also empty its cache",
                  &error);
    else
        judge(r, "float", &a);

    error = (feeler_error){0};
    if (!device->has_double)
        say(r, "warning", "double", "choose another device for --level reference",
            "this device has no double precision");
    else if (arithmetic_try(device, true, &a, &error))
        say_error(r, "double", "choose another device for --level reference", &error);
    else
        judge(r, "double", &a);
    feeler_device_close(device);
}

char *feeler_doctor_json(const char *select, feeler_error *error) {
    report r = {.checks = json_array()};
    char *text = NULL;
    if (r.checks) {
        check_loader(&r);
        check_platforms(&r);
        check_cache(&r);
        check_formats(&r);
        check_device(&r, select);
    }
    json_t *root = r.checks && !r.broken ? json_pack("{s:O}", "checks", r.checks) : NULL;
    if (root)
        text = json_dumps(root, JSON_INDENT(2));
    if (!text)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory while checking the installation");
    json_decref(root);
    json_decref(r.checks);
    return text;
}
