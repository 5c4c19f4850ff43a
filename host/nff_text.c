/* nff_text.c - reading words and numbers from an NFF file. */
#include "nff_text.h"
#include "number.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int nff_fail(nff_text *text, const char *format, ...) {
    char what[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return fail_at(text->error, FEELER_BAD_INPUT, text->place, "%s", what);
}

/* ---- the file ---- */

/* Reads to the end, or to the first zero byte: that is no text, and the words before it say where it is. */
static int read_stream(nff_text *text, FILE *file) {
    size_t size = 0, capacity = 0, got = 1;
    while (got) {
        if (capacity - size < 2) {
            size_t bigger = capacity ? capacity * 2 : 1 << 16;
            char *grown = bigger > capacity ? realloc(text->text, bigger) : NULL;
            if (!grown)
                return fail(text->error, FEELER_OUT_OF_MEMORY, "out of memory");
            text->text = grown;
            capacity = bigger;
        }
        got = fread(text->text + size, 1, capacity - size - 1, file);
        bool zero = memchr(text->text + size, 0, got) != NULL;
        size += got;
        if (zero)
            break;
    }
    if (ferror(file))
        return fail_at(text->error, FEELER_IO, text->place, "cannot be read: %s", strerror(errno));
    text->text[size] = 0;
    text->cursor = text->line_start = text->text;
    text->end = text->text + size;
    return 0;
}

int nff_open(nff_text *text, const char *path, const char *source, feeler_error *error) {
    *text = (nff_text){.line = 1, .source = source, .place = {source, 0, 0}, .error = error};
    FILE *file = fopen(path, "rb");
    if (!file)
        return fail_at(error, FEELER_IO, text->place, "cannot be opened: %s", strerror(errno));
    int status = read_stream(text, file);
    fclose(file);
    return status;
}

void nff_close(nff_text *text) {
    free(text->text);
    text->text = NULL;
}

size_t nff_left(const nff_text *text) {
    return (size_t)(text->end - text->cursor);
}

/* ---- words ---- */

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

static void skip_blanks(nff_text *text) {
    while (is_blank(*text->cursor))
        text->cursor++;
}

bool nff_line_goes_on(nff_text *text) {
    skip_blanks(text);
    return text->cursor < text->end && *text->cursor != '\n' && *text->cursor != '#';
}

static void skip_to_word(nff_text *text) {
    while (!nff_line_goes_on(text) && text->cursor < text->end) {
        while (text->cursor < text->end && *text->cursor != '\n')
            text->cursor++;
        if (text->cursor < text->end) {
            text->line_start = ++text->cursor;
            text->line++;
        }
    }
}

int nff_next_word(nff_text *text) {
    skip_to_word(text);
    text->word = text->cursor;
    text->place = (place){text->source, text->line, (int)(text->cursor - text->line_start) + 1};
    for (; text->cursor < text->end && *text->cursor != '\n' && !is_blank(*text->cursor); text->cursor++) {
        unsigned char byte = (unsigned char)*text->cursor;
        if (byte <= ' ' || byte > '~') {
            text->place.column += (int)(text->cursor - text->word);
            return nff_fail(text, "byte 0x%02x is not text: this is no NFF file", byte);
        }
    }
    text->length = (size_t)(text->cursor - text->word);
    return text->length > 0;
}

bool nff_word_is(const nff_text *text, const char *word) {
    return text->length == strlen(word) && memcmp(text->word, word, text->length) == 0;
}

/* ---- numbers ---- */

/* The word read last as a number; the byte after it makes room for an end of string meanwhile. */
static number_result parse_number(nff_text *text, double *value) {
    char after = *text->cursor;
    *text->cursor = 0;
    number_result result = number_read(text->word, value);
    *text->cursor = after;
    return result;
}

int nff_number(nff_text *text, const char *what, double low, double high, double *value) {
    int found = nff_next_word(text);
    if (found < 0)
        return -1;
    if (!found)
        return nff_fail(text, "the file ends where %s should follow", what);
    int shown = text->length < 40 ? (int)text->length : 40;
    double number;
    number_result result = parse_number(text, &number);
    if (result == NUMBER_MALFORMED)
        return nff_fail(text, "%s should be a number, not '%.*s'", what, shown, text->word);
    if (result == NUMBER_NOT_FINITE)
        return nff_fail(text, "%s should be a finite number, not '%.*s'", what, shown, text->word);
    if ((number < low || number > high) && isfinite(low) && isfinite(high))
        return nff_fail(text, "%s should be from %.10g to %.10g, not %.10g", what, low, high, number);
    if (number < low || number > high)
        return nff_fail(text, "%s should be at %s %.10g, not %.10g", what, number < low ? "least" : "most",
                        number < low ? low : high, number);
    *value = number;
    return 0;
}

int nff_whole_number(nff_text *text, const char *what, int low, int high, int *value) {
    double number;
    if (nff_number(text, what, low, high, &number))
        return -1;
    if (number != floor(number))
        return nff_fail(text, "%s should be a whole number, not %.10g", what, number);
    *value = (int)number;
    return 0;
}

int nff_vector(nff_text *text, const char *what, vec3 *value) {
    return nff_number(text, what, -HUGE_VAL, HUGE_VAL, &value->x) ||
                   nff_number(text, what, -HUGE_VAL, HUGE_VAL, &value->y) ||
                   nff_number(text, what, -HUGE_VAL, HUGE_VAL, &value->z)
               ? -1
               : 0;
}

int nff_colour(nff_text *text, const char *what, double high, vec3 *value) {
    return nff_number(text, what, 0, high, &value->x) || nff_number(text, what, 0, high, &value->y) ||
                   nff_number(text, what, 0, high, &value->z)
               ? -1
               : 0;
}
