/* blocks.h - primitives of one kind side by side, and boxes around them. */
#ifndef FEELER_BLOCKS_H
#define FEELER_BLOCKS_H

#include "packed.h"

/* What a node's child is: a node's number and LINK_NODE, or a block's place and tag. */
typedef struct link {
    uint32_t place, tag;
} link;

bounds empty_bounds(void);
bounds join(bounds a, bounds b);
bounds numbers_bounds(const packed *packed, const uint32_t *numbers, size_t count);

/* Room first, so that nothing fails on the way: for the blocks of so many more primitives. */
int reserve_blocks(packed *packed, const uint32_t *numbers, size_t count, feeler_error *error);

/* Sorts primitives' numbers so that those that may share a block are neighbours; returns how many groups there are. */
size_t group_by_tag(const packed *packed, uint32_t *numbers, size_t count);
/* How many of the numbers, from the first on, are of its group. */
size_t run_length(const packed *packed, const uint32_t *numbers, size_t count);
/* Makes a block of up to `width` primitives of one group; there is room. */
link add_block(packed *packed, const uint32_t *numbers, size_t count);

/* Blocks of neighbours in the list, each with a link; for scenes without a tree. */
int list_blocks(packed *packed, const uint32_t *numbers, size_t count, feeler_error *error);

#endif
