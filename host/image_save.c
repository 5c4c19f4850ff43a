/* image_save.c - writes a picture under its final name only when the whole of it is on the disk. */
#include "clock.h"
#include "image.h"
#include "replacement.h"
#include "scene.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct format {
    const char *ending;
    bool alpha;       /* can keep it */
    bool sixteen_bit; /* has the choice of 8 or 16 bits */
    bool channels;    /* keeps those beside the picture */
} format;

static const format formats[] = {
    {".exr", true, false, true},    {".hdr", false, false, false}, {".png", true, true, false},
    {".tif", true, true, false},    {".tiff", true, true, false},  {".jpg", false, false, false},
    {".jpeg", false, false, false},
};

static const format *find_format(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash + 1 : path, '.');
    for (size_t i = 0; dot && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(formats[i].ending, dot) == 0)
            return &formats[i];
    return NULL;
}

static int check_format(const char *path, const feeler_save_options *options, feeler_error *error) {
    static const char known[] = "endings are .exr, .hdr, .png, .tif, .tiff, .jpg, .jpeg";
    const format *f = find_format(path);
    if (!f) {
        const char *slash = strrchr(path, '/');
        const char *dot = strrchr(slash ? slash + 1 : path, '.');
        if (!dot)
            return fail(error, FEELER_BAD_USAGE, "%s: the name has no ending that tells the picture's format; %s", path,
                        known);
        return fail(error, FEELER_BAD_USAGE, "%s: unknown picture format '%s'; %s", path, dot, known);
    }
    if (options->alpha && !f->alpha)
        return fail(error, FEELER_BAD_USAGE, "%s: %s files keep no alpha; use .exr, .png or .tif", path, f->ending);
    if (options->channels && !f->channels)
        return fail(error, FEELER_BAD_USAGE, "%s: %s files keep no channels beside the picture; use .exr", path,
                    f->ending);
    if (options->sixteen_bit && !f->sixteen_bit)
        return fail(error, FEELER_BAD_USAGE, "%s: 16 bits are for .png and .tif; %s", path,
                    f->ending[1] == 'j' ? "JPEG has 8" : "this format is always floating point");
    return 0;
}

/* The folder part of a path, "." where it has none. To be freed. */
static char *folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    if (!slash)
        return strdup(".");
    return strndup(path, slash == path ? 1 : (size_t)(slash - path));
}

static int check_folder(const char *path, feeler_error *error) {
    struct stat info;
    int result = -1;
    char *folder = folder_of(path);
    if (!folder)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    if (stat(folder, &info))
        fail(error, FEELER_IO, "%s: cannot write into the folder '%s': %s", path, folder, strerror(errno));
    else if (!S_ISDIR(info.st_mode))
        fail(error, FEELER_IO, "%s: '%s' is not a folder", path, folder);
    else if (access(folder, W_OK | X_OK))
        fail(error, FEELER_IO, "%s: cannot write into the folder '%s': %s", path, folder, strerror(errno));
    else
        result = 0;
    free(folder);
    return result;
}

int feeler_image_can_save(const char *path, const feeler_save_options *options, feeler_error *error) {
    static const feeler_save_options plain;
    struct stat info;
    if (!options)
        options = &plain;
    if (!path || !*path)
        return fail(error, FEELER_BAD_USAGE, "the picture's file name is empty");
    bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return fail(error, FEELER_IO, "%s: is a folder; name a file", path);
    if (check_format(path, options, error))
        return -1;
    if (exists && !S_ISREG(info.st_mode))
        return fail(error, FEELER_IO, "%s: is not a regular file", path);
    if (exists && access(path, W_OK))
        return fail(error, FEELER_IO, "%s: %s", path, strerror(errno));
    if (check_folder(path, error))
        return -1;
    return image_io_known(path, error);
}

int feeler_image_save(feeler_image *image, const char *path, const feeler_save_options *options, feeler_error *error) {
    static const feeler_save_options plain;
    replacement file;
    if (!options)
        options = &plain;
    double start = seconds_now();
    if (feeler_image_can_save(path, options, error) || replacement_open(&file, path, error))
        return -1;
    if (replacement_close(&file, image_io_write(image, file.temporary, path, options, error), error))
        return -1;
    double seconds = seconds_now() - start;
    image->stats.write += seconds;
    image->stats.total += seconds;
    return 0;
}
