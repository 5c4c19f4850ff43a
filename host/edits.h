/* edits.h - how far two words are apart: for names that were misspelt. */
#ifndef FEELER_EDITS_H
#define FEELER_EDITS_H

#include <stddef.h>

enum { LONGEST_WORD = 48 };

/* Letters to insert, delete, replace or swap with their neighbour (the optimal string alignment distance); SIZE_MAX where
 * either word is longer than LONGEST_WORD. */
size_t edits_between(const char *a, const char *b);

#endif
