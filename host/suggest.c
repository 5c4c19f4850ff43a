/* suggest.c - which known name was probably meant by an unknown one. */
#include "edits.h"
#include "schema.h"

#include <stdio.h>
#include <string.h>

suggestion suggest_for(const char *name) {
    /* A third of the letters may be wrong: more, and the guess is as likely to mislead. */
    return (suggestion){name, NULL, (strlen(name) + 2) / 3 + 1};
}

void suggest_candidate(suggestion *suggestion, const char *candidate) {
    size_t distance = edits_between(suggestion->name, candidate);
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
