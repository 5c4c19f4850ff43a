/* tiles.h - cuts a region into the launches that compute it, each about as long as it takes to stay responsive. */
#ifndef FEELER_TILES_H
#define FEELER_TILES_H

#include <stdbool.h>
#include <stddef.h>

typedef struct tile {
    int x0, y0, x1, y1; /* half open, pixels of the whole picture */
} tile;

typedef struct tiles {
    int region[4], group[2];
    size_t budget; /* pixels for the next tile */
    int x, y, height;
} tiles;

void tiles_start(tiles *tiles, const int region[4], const int group[2], size_t budget);
/* The next tile, of at most `budget` pixels (but at least one work group). False when all are done. */
bool tiles_next(tiles *tiles, tile *tile);

#endif
