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

void feeler_error_format(const feeler_error *error, char *buffer, size_t size) {
    if (error->source[0] && error->line > 0)
        snprintf(buffer, size, "%s:%d:%d: %s", error->source, error->line, error->column, error->text);
    else if (error->source[0])
        snprintf(buffer, size, "%s: %s", error->source, error->text);
    else
        snprintf(buffer, size, "%s", error->text);
}
