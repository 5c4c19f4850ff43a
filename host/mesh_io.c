/* mesh_io.c - the files that assimp opens: a material library that is not there is noticed, for assimp goes on without, and
 * an OBJ file is read as assimp understands it. */
#include "mesh_io.h"
#include "mesh_file.h"

#include <assimp/cfileio.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static FILE *stream_of(struct aiFile *file) {
    return (FILE *)(void *)file->UserData;
}

static size_t read_items(struct aiFile *file, char *to, size_t size, size_t count) {
    return fread(to, size, count, stream_of(file));
}

static size_t write_items(struct aiFile *file, const char *from, size_t size, size_t count) {
    (void)file, (void)from, (void)size, (void)count;
    return 0;
}

static size_t position_of(struct aiFile *file) {
    long position = ftell(stream_of(file));
    return position < 0 ? 0 : (size_t)position;
}

static size_t size_of(struct aiFile *file) {
    long here = ftell(stream_of(file));
    if (here < 0 || fseek(stream_of(file), 0, SEEK_END))
        return 0;
    long size = ftell(stream_of(file));
    return fseek(stream_of(file), here, SEEK_SET) || size < 0 ? 0 : (size_t)size;
}

static enum aiReturn seek_to(struct aiFile *file, size_t offset, enum aiOrigin origin) {
    int from = origin == aiOrigin_SET ? SEEK_SET : origin == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
    return fseek(stream_of(file), (long)offset, from) ? aiReturn_FAILURE : aiReturn_SUCCESS;
}

static void flush(struct aiFile *file) {
    (void)file;
}

/* The plain text of an OBJ file in place of its stream; NULL: out of memory. */
static FILE *open_plain(mesh_io *io, FILE *stream) {
    struct stat about;
    if (fstat(fileno(stream), &about) || !S_ISREG(about.st_mode))
        return stream;
    size_t length = (size_t)about.st_size;
    free(io->text);
    io->text = mesh_obj_plain(stream, &length);
    fclose(stream);
    stream = io->text ? fmemopen(io->text, length, "rb") : NULL;
    io->out_of_memory |= !stream;
    return stream;
}

static struct aiFile *open_file(struct aiFileIO *calls, const char *path, const char *mode) {
    mesh_io *io = (mesh_io *)(void *)calls->UserData;
    struct aiFile *file = malloc(sizeof *file);
    FILE *stream = file && !strpbrk(mode, "wa+") ? fopen(path, "rb") : NULL;
    if (stream && mesh_ends_with(path, ".obj"))
        stream = open_plain(io, stream);
    if (stream) {
        *file =
            (struct aiFile){read_items, write_items, position_of, size_of, seek_to, flush, (aiUserData)(void *)stream};
        return file;
    }
    io->out_of_memory |= !file;
    free(file);
    if (!io->missing[0] && mesh_ends_with(path, ".mtl"))
        snprintf(io->missing, sizeof io->missing, "%s", path);
    return NULL;
}

static void close_file(struct aiFileIO *calls, struct aiFile *file) {
    (void)calls;
    fclose(stream_of(file));
    free(file);
}

void mesh_io_start(mesh_io *io) {
    *io = (mesh_io){.calls = {open_file, close_file, (aiUserData)(void *)io}};
}

void mesh_io_end(mesh_io *io) {
    free(io->text);
    io->text = NULL;
}
