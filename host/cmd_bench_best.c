/* cmd_bench_best.c - which work group is best, and keeping it. */
#include "cmd_bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A run that render could do. */
static const run *find_size(const bench_case *b, const int size[2]) {
    for (int i = 0; i < b->count; i++)
        if (memcmp(b->runs[i].size, size, sizeof b->runs[i].size) == 0)
            return b->runs[i].verdict == VERDICT_CORRECT && !b->runs[i].forced ? &b->runs[i] : NULL;
    return NULL;
}

/* The sum of a size's medians over the cases; negative: one of them has no time for it. */
static double sum_of(const bench_case *const *cases, int count, const int size[2]) {
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const run *r = find_size(cases[i], size);
        if (!r)
            return -1;
        sum += times_of(r->kernel, r->repeats).median;
    }
    return sum;
}

/* The best run of the first case, judged by all: of the least sum of medians, if that is below the sum of the
 * default's least times, else the default. */
static const run *best_of_all(const bench_case *const *cases, int count) {
    const run *best = NULL;
    double least = 0, bar = 0;
    bool standing = true; /* the default runs everywhere */
    for (int i = 0; i < count; i++) {
        standing = standing && cases[i]->runs->verdict == VERDICT_CORRECT;
        bar += times_of(cases[i]->runs->kernel, cases[i]->runs->repeats).least;
    }
    for (int i = 0; i < cases[0]->count; i++) {
        const run *r = &cases[0]->runs[i];
        double sum = sum_of(cases, count, r->size);
        if (sum > 0 && (!best || sum < least)) {
            best = r;
            least = sum;
        }
    }
    return standing && least >= bar ? cases[0]->runs : best;
}

const run *best_of(const bench_case *b) {
    return b->count ? best_of_all(&b, 1) : NULL;
}

/* What tells a kernel and its device apart, as far as keeping goes. */
static bool same_kernel(const json_t *a, const json_t *b) {
    static const char *const keys[] = {"device", "options"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (!json_equal(json_object_get(a, keys[i]), json_object_get(b, keys[i])))
            return false;
    return true;
}

static const char *text_at(const run *r, const char *key) {
    return json_string_value(json_object_get(r->stats, key));
}

static int keep_run(const char *scene, const run *r) {
    feeler_error error = {0};
    char *text = json_dumps(r->stats, 0), *path = feeler_tuned_path();
    int code = EXIT_FAILED, samples = (int)json_integer_value(json_object_get(r->stats, "samples"));
    if (!text)
        report_failure("out of memory");
    else if (feeler_tuned_keep(text, &error))
        code = report_error(&error);
    else
        code = EXIT_DONE;
    if (code == EXIT_DONE)
        report_note("kept in %s: %dx%d for kernels like those of %s at level %s with %d sample%s, on %s", path,
                    r->size[0], r->size[1], scene, text_at(r, "level"), samples, samples == 1 ? "" : "s",
                    text_at(r, "device"));
    free(text);
    feeler_free(path);
    return code;
}

int best_keep(const bench_case *cases, int count) {
    const bench_case **alike = calloc((size_t)count + 1, sizeof *alike);
    bool *done = calloc((size_t)count + 1, sizeof *done);
    int code = alike && done ? EXIT_DONE : EXIT_FAILED;
    if (code != EXIT_DONE)
        report_failure("out of memory");
    for (int i = 0; i < count && code == EXIT_DONE; i++) {
        const run *best = best_of(&cases[i]);
        int found = 0;
        for (int k = i; best && !done[i] && k < count; k++) {
            const run *other = best_of(&cases[k]);
            if (!other || !same_kernel(best->stats, other->stats))
                continue;
            alike[found++] = &cases[k];
            done[k] = k > i;
        }
        best = found ? best_of_all(alike, found) : NULL;
        if (best)
            code = keep_run(cases[i].scene, best);
    }
    free(alike);
    free(done);
    return code;
}
