/* cmd_bench_table.c - a case of a sweep as a table for people. */
#include "cmd_bench.h"

#include <stdio.h>

static int whole(const json_t *stats, const char *key, size_t index) {
    const json_t *value = json_object_get(stats, key);
    return (int)json_integer_value(json_is_array(value) ? json_array_get(value, index) : value);
}

/* What all runs have in common; any render's statistics tell it. */
static void print_head(const bench_case *b, const plan *p) {
    const json_t *stats = NULL;
    for (int i = 0; i < b->count && !stats; i++)
        stats = b->runs[i].stats;
    printf("%s", b->scene);
    if (stats)
        printf(": %dx%d, %d sample%s a pixel, %s, lanes %d, %s", whole(stats, "size", 0), whole(stats, "size", 1),
               whole(stats, "samples", 0), whole(stats, "samples", 0) == 1 ? "" : "s",
               json_string_value(json_object_get(stats, "level")), whole(stats, "lanes", 0),
               json_string_value(json_object_get(stats, "device")));
    printf("\n  %d repeat%s in turn after %d warm-up%s; milliseconds; * is render's default, ! what it refuses\n",
           p->repeat, p->repeat == 1 ? "" : "s", p->warm_up, p->warm_up == 1 ? "" : "s");
    printf("  %-11s %10s %10s %10s %11s %10s %10s\n", "work group", "kernel", "least", "most", "to default", "wall",
           "compile");
}

static void print_run(const run *r, double standard) {
    char size[32];
    snprintf(size, sizeof size, "%dx%d", r->size[0], r->size[1]);
    printf("%c %-11s", r->is_default ? '*' : r->forced ? '!' : ' ', r->size[0] ? size : "default");
    if (r->verdict != VERDICT_CORRECT) {
        printf(" %s%s\n", r->verdict == VERDICT_CONSTRAINTS ? "invalid: " : "", r->detail);
        return;
    }
    const times kernel = times_of(r->kernel, r->repeats), wall = times_of(r->wall, r->repeats);
    printf(" %10.2f %10.2f %10.2f", kernel.median, kernel.least, kernel.most);
    if (standard > 0)
        printf(" %11.2f", kernel.median / standard);
    else
        printf(" %11s", "");
    printf(" %10.2f %10.2f\n", wall.median, r->compile);
}

void table_print(const bench_case *b, const plan *p) {
    const run *best = best_of(b);
    const times standard = times_of(b->runs->kernel, b->runs->verdict == VERDICT_CORRECT ? b->runs->repeats : 0);
    print_head(b, p);
    for (int i = 0; i < b->count; i++)
        print_run(&b->runs[i], standard.median);
    if (best && best->is_default)
        puts("  no size is faster than all repeats of the default");
    else if (best)
        printf("  best: %dx%d\n", best->size[0], best->size[1]);
    puts("");
    fflush(stdout);
}
