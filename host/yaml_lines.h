/* yaml_lines.h - a short cut for long lists with an item to a line.
 *
 * libyaml takes 0.8 s for 200 000 lines such as `- sphere: {centre: [1, 2, 3], radius: 1}`. Runs of lines that are this
 * plain are read here, ten times as fast, and libyaml sees an alias in their stead. Whenever anything is then amiss, the
 * whole file goes through libyaml alone, so that what is valid, what it means and what an error says never depend on this.
 */
#ifndef FEELER_YAML_LINES_H
#define FEELER_YAML_LINES_H

#include "node.h"

#define YAML_LINES_ALIAS "feeler-lines-" /* and the run's number */

/* Lines that follow each other, read as items of a list. */
typedef struct yaml_run {
    feeler_node *first; /* linked by `next`; NULL when used up */
    size_t weight;      /* nodes in all */
} yaml_run;

typedef struct yaml_lines {
    char *text; /* the file with each run's lines empty, but for an alias on the first */
    size_t size;
    yaml_run *runs;
    size_t count, capacity;
} yaml_lines;

/* Reads the runs of a text, which ends with a zero byte and holds none. False when there is none worth it, or no memory for it: there is nothing to free then. */
bool yaml_lines_read(const char *text, size_t size, node_pool *pool, yaml_lines *lines);
/* The run that an alias stands for, which is then used up; without a first node where it is not one of ours. */
yaml_run yaml_lines_take(yaml_lines *lines, const char *alias);
/* Whether every run was taken. */
bool yaml_lines_done(const yaml_lines *lines);
void yaml_lines_free(yaml_lines *lines);

#endif
