/* suggest.c - which known name was probably meant by an unknown one. */
#include "schema.h"

#include <stdio.h>
#include <string.h>

enum { LONGEST = 48 }; /* names beyond it get no suggestion */

static size_t least(size_t a, size_t b) {
    return a < b ? a : b;
}

/* Edits (insert, delete, replace, swap neighbours) from one name to the other: the optimal string alignment distance. */
static size_t edit_distance(const char *a, const char *b) {
    size_t rows[3][LONGEST + 1];
    size_t a_length = strlen(a), b_length = strlen(b);
    if (a_length > LONGEST || b_length > LONGEST)
        return LONGEST;
    size_t *before = rows[0], *above = rows[1], *row = rows[2];
    for (size_t j = 0; j <= b_length; j++)
        above[j] = before[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t replaced = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = least(replaced, least(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = least(row[j], before[j - 2] + 1);
        }
        size_t *spare = before;
        before = above;
        above = row;
        row = spare;
    }
    return above[b_length];
}

suggestion suggest_for(const char *name) {
    /* A third of the letters may be wrong: more, and the guess is as likely to mislead. */
    return (suggestion){name, NULL, (strlen(name) + 2) / 3 + 1};
}

void suggest_candidate(suggestion *suggestion, const char *candidate) {
    size_t distance = edit_distance(suggestion->name, candidate);
    if (distance < suggestion->distance) {
        suggestion->distance = distance;
        suggestion->best = candidate;
    }
}

const char *shown(const char *text, char buffer[SHOWN_SIZE]) {
    size_t length = strlen(text), kept = length;
    if (length > SHOWN_SIZE - 8) {
        kept = SHOWN_SIZE - 8;
        while (kept > 0 && ((unsigned char)text[kept] & 0xC0) == 0x80)
            kept--;
    }
    for (size_t i = 0; i < kept; i++)
        buffer[i] = (unsigned char)text[i] < 0x20 || text[i] == 0x7F ? ' ' : text[i];
    strcpy(buffer + kept, kept < length ? "…" : "");
    return buffer;
}

const char *suggest_text(const suggestion *suggestion, char buffer[SUGGESTION_SIZE]) {
    char name[SHOWN_SIZE];
    buffer[0] = '\0';
    if (suggestion->best)
        snprintf(buffer, SUGGESTION_SIZE, " (did you mean '%s'?)", shown(suggestion->best, name));
    return buffer;
}
