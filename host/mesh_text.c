/* mesh_text.c - numbers in mesh files that are text: assimp takes "1.5x" for 1.5 and "nan" for a place, and says nothing. */
#include "mesh_file.h"
#include "number.h"
#include "schema.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* A walk over a text in memory, word by word, that knows where it is. */
typedef struct walk {
    char *at, *end; /* *end is a byte of its own: words are terminated in place */
    const char *line_start;
    int line;
} walk;

typedef struct word {
    char *text;
    size_t length;
    int line, column;
} word;

static bool ends_line(char c) {
    return c == '\n' || c == '\r';
}

static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\0';
}

static void start_line(walk *w) {
    w->at += w->at + 1 < w->end && w->at[0] == '\r' && w->at[1] == '\n' ? 2 : 1;
    w->line_start = w->at;
    w->line++;
}

/* OBJ's lines go on after a backslash. */
static bool continues(const walk *w) {
    return *w->at == '\\' && w->at + 1 < w->end && ends_line(w->at[1]);
}

/* The next word of the line. False at the line's end or a comment. */
static bool next_word(walk *w, word *found) {
    for (;; w->at++) {
        while (w->at < w->end && continues(w)) {
            w->at++;
            start_line(w);
        }
        if (w->at >= w->end || !is_space(*w->at))
            break;
    }
    if (w->at >= w->end || ends_line(*w->at) || *w->at == '#')
        return false;
    *found = (word){w->at, 0, w->line, (int)(w->at - w->line_start) + 1};
    while (w->at < w->end && !is_space(*w->at) && !ends_line(*w->at) && !continues(w))
        w->at++;
    found->length = (size_t)(w->at - found->text);
    return true;
}

static void skip_line(walk *w) {
    while (w->at < w->end && !ends_line(*w->at)) {
        if (continues(w)) {
            w->at++;
            start_line(w);
        } else {
            w->at++;
        }
    }
    if (w->at < w->end)
        start_line(w);
}

static bool is_word(const word *w, const char *text) {
    return w->length == strlen(text) && strncasecmp(w->text, text, w->length) == 0;
}

/* ---- faults ---- */

int mesh_check_number(const char *text, bool finite, char *why, size_t size) {
    char name[SHOWN_SIZE];
    number_result result = number_check(text);
    if (result == NUMBER_OK || (result == NUMBER_NOT_FINITE && !finite))
        return FEELER_OK;
    snprintf(why, size, result == NUMBER_NOT_FINITE ? "'%s' is not a finite number" : "'%s' is not a number",
             shown(text, name));
    return FEELER_BAD_INPUT;
}

static int check_number(const word *w, mesh_fault *fault) {
    char after = w->text[w->length];
    w->text[w->length] = '\0';
    int code = mesh_check_number(w->text, true, fault->text, sizeof fault->text);
    w->text[w->length] = after;
    if (code != FEELER_OK) {
        fault->line = w->line;
        fault->column = w->column;
    }
    return code;
}

/* Numbers to the line's end; `counts` has a bit for each right count of them, `wanted` says it. */
static int check_numbers(walk *w, const word *keyword, unsigned counts, const char *wanted, mesh_fault *fault) {
    word number;
    int code = FEELER_OK;
    unsigned count = 0;
    for (; code == FEELER_OK && next_word(w, &number); count++)
        code = check_number(&number, fault);
    if (code != FEELER_OK || (count < 32 && counts >> count & 1))
        return code;
    fault->line = keyword->line;
    fault->column = keyword->column;
    snprintf(fault->text, sizeof fault->text, "'%.*s' has %u numbers, but needs %s", (int)keyword->length,
             keyword->text, count, wanted);
    return FEELER_BAD_INPUT;
}

/* ---- OBJ ---- */

/* Past a whole number other than 0, or NULL. */
static const char *skip_index(const char *at) {
    bool zero = true;
    const char *start = *at == '-' || *at == '+' ? at + 1 : at;
    for (at = start; *at >= '0' && *at <= '9'; at++)
        zero = zero && *at == '0';
    return at == start || zero ? NULL : at;
}

/* A corner of a face is v, v/vt, v//vn or v/vt/vn; some programs write "v/" too. */
static bool is_corner(const char *text) {
    text = skip_index(text);
    for (int slash = 0; text && *text == '/' && slash < 2; slash++) {
        text++;
        if (*text && *text != '/')
            text = skip_index(text);
    }
    return text && *text == '\0';
}

static int check_corners(walk *w, mesh_fault *fault) {
    char text[SHOWN_SIZE];
    word corner;
    int code = FEELER_OK;
    while (code == FEELER_OK && next_word(w, &corner)) {
        char after = corner.text[corner.length];
        corner.text[corner.length] = '\0';
        if (!is_corner(corner.text)) {
            *fault = (mesh_fault){.line = corner.line, .column = corner.column};
            snprintf(fault->text, sizeof fault->text,
                     "'%s' is no corner of a face: v, v/vt, v//vn or v/vt/vn, whole numbers but 0",
                     shown(corner.text, text));
            code = FEELER_BAD_INPUT;
        }
        corner.text[corner.length] = after;
    }
    return code;
}

static int check_obj_line(walk *w, mesh_fault *fault) {
    word keyword;
    if (!next_word(w, &keyword))
        return FEELER_OK;
    if (is_word(&keyword, "v")) /* assimp would leave out any other, and number the rest anew */
        return check_numbers(w, &keyword, 1U << 3 | 1U << 4 | 1U << 6, "3, 4 or 6", fault);
    if (is_word(&keyword, "vn"))
        return check_numbers(w, &keyword, 1U << 3, "3", fault);
    if (is_word(&keyword, "vt"))
        return check_numbers(w, &keyword, 1U << 1 | 1U << 2 | 1U << 3, "1 to 3", fault);
    return is_word(&keyword, "f") ? check_corners(w, fault) : FEELER_OK;
}

/* ---- STL ---- */

/* The facets' normals are not read, and not a number where the facet has no area. */
static int check_stl_line(walk *w, mesh_fault *fault) {
    word keyword;
    return next_word(w, &keyword) && is_word(&keyword, "vertex") ? check_numbers(w, &keyword, 1U << 3, "3", fault)
                                                                 : FEELER_OK;
}

/* ---- the whole ---- */

static int check_lines(FILE *file, size_t length, int (*check)(walk *, mesh_fault *), mesh_fault *fault) {
    char *text = malloc(length + 1);
    if (!text) {
        snprintf(fault->text, sizeof fault->text, "out of memory");
        return FEELER_OUT_OF_MEMORY;
    }
    rewind(file);
    length = fread(text, 1, length, file);
    text[length] = '\0';
    walk w = {.at = text, .end = text + length, .line_start = text, .line = 1};
    int code = FEELER_OK;
    while (code == FEELER_OK && w.at < w.end) {
        code = check(&w, fault);
        if (code == FEELER_OK)
            skip_line(&w);
    }
    free(text);
    return code;
}

int mesh_check_obj(FILE *file, size_t length, mesh_fault *fault) {
    return check_lines(file, length, check_obj_line, fault);
}

/* One word of a line of numbers, as assimp wants it. Returns where the output goes on. */
static char *copy_word(char *to, const word *from) {
    const char *at = from->text, *end = at + from->length;
    at += *at == '+';
    if (at < end && *at == '.')
        *to++ = '0';
    memcpy(to, at, (size_t)(end - at));
    return to + (end - at);
}

static char *copy_line(char *to, walk *w) {
    const char *start = w->at;
    word one;
    bool found = next_word(w, &one);
    if (found && (is_word(&one, "v") || is_word(&one, "vn") || is_word(&one, "vt") || is_word(&one, "f"))) {
        for (size_t i = 0; i < one.length; i++)
            one.text[i] |= 0x20; /* "V" too */
        do {
            to = copy_word(to, &one);
            *to++ = ' ';
        } while (next_word(w, &one));
        skip_line(w);
        to[-1] = '\n';
        return to;
    }
    skip_line(w);
    memcpy(to, start, (size_t)(w->at - start));
    return to + (w->at - start);
}

char *mesh_obj_plain(FILE *file, size_t *length) {
    size_t size = *length;
    char *text = malloc(size + 1), *plain = malloc(size + size / 2 + 2), *to = plain;
    if (!text || !plain) {
        free(text);
        free(plain);
        return NULL;
    }
    size = fread(text, 1, size, file);
    text[size] = '\0';
    walk w = {.at = text, .end = text + size, .line_start = text, .line = 1};
    while (w.at < w.end)
        to = copy_line(to, &w);
    free(text);
    *length = (size_t)(to - plain);
    return plain;
}

int mesh_check_stl_text(FILE *file, size_t length, mesh_fault *fault) {
    return check_lines(file, length, check_stl_line, fault);
}
