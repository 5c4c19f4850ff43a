/* tiles.c */
#include "tiles.h"

#include <string.h>

void tiles_start(tiles *t, const int region[4], const int group[2], size_t budget) {
    memcpy(t->region, region, sizeof t->region);
    memcpy(t->group, group, sizeof t->group);
    t->budget = budget;
    t->x = region[0];
    t->y = region[1];
    t->height = 0;
}

static int smaller(int a, int b) {
    return a < b ? a : b;
}

/* `pixels` / `by` rounded down to whole groups, one at least. */
static int whole_groups(size_t pixels, int by, int group) {
    size_t length = pixels / (size_t)by, groups = length / (size_t)group;
    if (groups < 1)
        groups = 1;
    return groups > (size_t)(1 << 20) / (size_t)group ? 1 << 20 : (int)groups * group;
}

/* Bands from the top down, as high as the budget allows for the whole width; a band that one group's height makes too
 * large is cut across as well. */
bool tiles_next(tiles *t, tile *tile) {
    if (t->y >= t->region[3])
        return false;
    int width = t->region[2] - t->region[0];
    if (t->x == t->region[0])
        t->height = smaller(whole_groups(t->budget, width, t->group[1]), t->region[3] - t->y);
    tile->x0 = t->x;
    tile->y0 = t->y;
    tile->y1 = t->y + t->height;
    tile->x1 = smaller(t->x + whole_groups(t->budget, t->height, t->group[0]), t->region[2]);
    t->x = tile->x1;
    if (t->x >= t->region[2]) {
        t->x = t->region[0];
        t->y = tile->y1;
    }
    return true;
}
