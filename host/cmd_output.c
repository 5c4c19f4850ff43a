/* cmd_output.c - names of output files, and text files that appear only when they are whole. */
#include "cmd.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *base_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Where the ending begins: at the last dot of the file's name, unless the name begins with it. */
static size_t ending_of(const char *path) {
    const char *base = base_of(path);
    const char *dot = strrchr(base, '.');
    return dot && dot != base ? (size_t)(dot - path) : strlen(path);
}

char *output_scene_name(const char *scene_path) {
    const char *base = base_of(scene_path);
    return strndup(base, ending_of(scene_path) - (size_t)(base - scene_path));
}

char *output_expand(const char *pattern, const char *name) {
    static const char mark[] = "{name}";
    size_t count = 0, name_length = strlen(name);
    for (const char *at = pattern; (at = strstr(at, mark)); at += sizeof mark - 1)
        count++;
    char *result = malloc(strlen(pattern) + count * name_length + 1);
    if (!result)
        return NULL;

    char *out = result;
    for (const char *at; (at = strstr(pattern, mark)); pattern = at + sizeof mark - 1) {
        memcpy(out, pattern, (size_t)(at - pattern));
        out += at - pattern;
        memcpy(out, name, name_length);
        out += name_length;
    }
    strcpy(out, pattern);
    return result;
}

static bool is_stdout(const char *path) {
    return strcmp(path, "-") == 0;
}

char *output_partial(const char *path) {
    if (is_stdout(path))
        return strdup(path);
    static const char mark[] = ".partial";
    size_t stem = ending_of(path), size = strlen(path) + sizeof mark;
    char *result = malloc(size);
    if (result)
        snprintf(result, size, "%.*s%s%s", (int)stem, path, mark, path + stem);
    return result;
}

bool output_ends_in(const char *path, const char *ending) {
    return strcasecmp(path + ending_of(path), ending) == 0;
}

bool output_is_file(const char *path, const char *other) {
    struct stat a, b;
    return stat(path, &a) == 0 && stat(other, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

int output_check_text(const char *path, const char *scene) {
    struct stat info;
    const char *base = base_of(path);
    if (is_stdout(path))
        return 0;
    if (output_is_file(path, scene)) {
        report_failure("%s: is the scene, which would be lost", path);
        return -1;
    }
    if (stat(path, &info) == 0) {
        if (!S_ISDIR(info.st_mode) && access(path, W_OK) == 0)
            return 0;
        report_failure("%s: %s", path, S_ISDIR(info.st_mode) ? "is a folder; name a file" : strerror(errno));
        return -1;
    }
    size_t length = (size_t)(base - path);
    char *folder = length ? strndup(path, length - (length > 1)) : strdup("."); /* without the slash, but for "/" */
    int result = folder ? access(folder, W_OK | X_OK) : -1;
    if (result)
        report_failure("%s: cannot write into the folder '%s': %s", path, folder ? folder : "", strerror(errno));
    free(folder);
    return result;
}

static int write_stream(FILE *file, const char *text) {
    bool written = fputs(text, file) >= 0 && fputc('\n', file) != EOF && fflush(file) == 0;
    /* A pipe cannot be synchronised; that is no failure. */
    if (written && fsync(fileno(file)) && errno != EINVAL && errno != EROFS)
        written = false;
    int reason = errno;
    if (fclose(file) && written)
        return -1;
    errno = reason;
    return written ? 0 : -1;
}

int output_write_text(const char *path, const char *text) {
    struct stat info;
    FILE *file = NULL;
    size_t size = strlen(path) + 40;
    char *temporary = malloc(size);
    if (!temporary)
        goto failed;
    if (is_stdout(path)) {
        if (puts(text) == EOF || fflush(stdout))
            goto failed;
        free(temporary);
        return 0;
    }

    bool direct = stat(path, &info) == 0 && !S_ISREG(info.st_mode);
    if (direct)
        snprintf(temporary, size, "%s", path);
    else
        snprintf(temporary, size, "%.*s.feeler-%ld.tmp", (int)(base_of(path) - path), path, (long)getpid());
    file = fopen(temporary, "w");
    if (!file)
        goto failed;
    if (write_stream(file, text) || (!direct && rename(temporary, path))) {
        int reason = errno;
        if (!direct)
            (void)unlink(temporary);
        errno = reason;
        goto failed;
    }
    free(temporary);
    return 0;
failed:
    report_failure("%s: cannot write: %s", is_stdout(path) ? "standard output" : path, strerror(errno));
    free(temporary);
    return -1;
}
