/* error.c - the caller-owned error: filled once, so that the first cause is the one that is told. */
#include "scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#ifndef FEELER_VERSION
#define FEELER_VERSION "unknown"
#endif

const char *feeler_version(void) {
    return FEELER_VERSION;
}

/* Ends `text` before a UTF-8 character that its buffer cut in two. */
static void trim_cut_character(char *text, size_t size) {
    size_t length = strlen(text);
    if (length + 1 < size)
        return;
    while (length > 0 && ((unsigned char)text[length - 1] & 0xC0) == 0x80)
        length--;
    if (length > 0 && ((unsigned char)text[length - 1] & 0x80))
        length--;
    text[length] = '\0';
}

static void fill(feeler_error *error, int code, place place, const char *format, va_list arguments) {
    if (!error || error->code != FEELER_OK)
        return;
    error->code = code;
    error->line = place.line;
    error->column = place.column;
    error->log[0] = '\0';
    snprintf(error->source, sizeof error->source, "%s", place.source ? place.source : "");
    trim_cut_character(error->source, sizeof error->source);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    trim_cut_character(error->text, sizeof error->text);
}

int fail(feeler_error *error, int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(error, code, (place){NULL, 0, 0}, format, arguments);
    va_end(arguments);
    return -1;
}

int fail_at(feeler_error *error, int code, place place, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(error, code, place, format, arguments);
    va_end(arguments);
    return -1;
}

/* For an error that nobody put into words. */
static const char *unknown_error(int code) {
    static const char *const texts[] = {
        [FEELER_OK] = "unknown error",
        [FEELER_BAD_INPUT] = "unknown error in a scene or setting",
        [FEELER_BAD_USAGE] = "unknown error: an argument is wrong",
        [FEELER_IO] = "unknown error while reading or writing a file",
        [FEELER_OUT_OF_MEMORY] = "out of memory",
        [FEELER_DEVICE] = "unknown error of the OpenCL device",
        [FEELER_INTERRUPTED] = "interrupted",
    };
    return code > 0 && (size_t)code < sizeof texts / sizeof *texts ? texts[code] : texts[FEELER_OK];
}

void feeler_error_format(const feeler_error *error, char *buffer, size_t size) {
    const char *text = error->text[0] ? error->text : unknown_error(error->code);
    if (error->source[0] && error->line > 0)
        snprintf(buffer, size, "%s:%d:%d: %s", error->source, error->line, error->column, text);
    else if (error->source[0])
        snprintf(buffer, size, "%s: %s", error->source, text);
    else
        snprintf(buffer, size, "%s", text);
}
