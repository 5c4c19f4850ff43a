/* nff_text.h - an NFF file as a row of words and numbers, each with its place.
 *
 * Functions that can fail return 0 or -1 and fill the error given at opening with "file:line:column: what".
 */
#ifndef FEELER_NFF_TEXT_H
#define FEELER_NFF_TEXT_H

#include "scene.h"

typedef struct nff_text {
    char *text; /* owned; a zero byte follows it */
    char *cursor, *end, *line_start;
    int line;
    const char *source; /* interned in the scene */
    const char *word;   /* the word read last; not terminated */
    size_t length;      /* of that word */
    place place;        /* where that word is, or where the file ends */
    feeler_error *error;
} nff_text;

/* Reads the whole file. `source` has to outlive the text. Close it also after a failure. */
int nff_open(nff_text *text, const char *path, const char *source, feeler_error *error);
void nff_close(nff_text *text);

/* The next word, over comments and ends of lines: 1, at the end of the file 0, for a byte that is no text -1. */
int nff_next_word(nff_text *text);
bool nff_word_is(const nff_text *text, const char *word);
/* Whether more follows on this line, before its comment. */
bool nff_line_goes_on(nff_text *text);
/* The rest of the file in bytes: no list in it can be longer. */
size_t nff_left(const nff_text *text);

/* The next word as a finite number from low to high; `what` names it in errors, as in "the sphere's radius". */
int nff_number(nff_text *text, const char *what, double low, double high, double *value);
int nff_whole_number(nff_text *text, const char *what, int low, int high, int *value);
/* Three numbers of any size. */
int nff_vector(nff_text *text, const char *what, vec3 *value);
/* Three numbers from 0 to high. */
int nff_colour(nff_text *text, const char *what, double high, vec3 *value);

/* Fails at the word read last. */
int nff_fail(nff_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
