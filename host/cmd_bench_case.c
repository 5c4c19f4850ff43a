/* cmd_bench_case.c - one scene, device, level and number of samples with every work group. */
#include "cmd_bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const verdict_names[] = {"correct", "timeout", "compile", "runtime", "correctness", "constraints"};

static const int usual_sizes[] = {1, 1, 4, 4, 8, 8, 16, 4, 16, 16, 64, 1};

int plan_sizes(const plan *p) {
    return p->groups.count ? p->groups.count : (int)(sizeof usual_sizes / sizeof *usual_sizes / 2);
}

void case_free(bench_case *b) {
    for (int i = 0; i < b->count; i++) {
        json_decref(b->runs[i].stats);
        free(b->runs[i].kernel);
        free(b->runs[i].wall);
    }
    free(b->runs);
    b->runs = NULL;
    b->count = 0;
}

static int add_run(bench_case *b, const plan *p, const int size[2]) {
    run *r = &b->runs[b->count++];
    *r = (run){.kernel = malloc((size_t)p->repeat * sizeof(double)),
               .wall = malloc((size_t)p->repeat * sizeof(double)),
               .is_default = b->count == 1};
    if (size)
        memcpy(r->size, size, sizeof r->size);
    if (r->kernel && r->wall)
        return 0;
    report_failure("out of memory");
    return -1;
}

static bool has_size(const bench_case *b, const int size[2]) {
    for (int i = 0; i < b->count; i++)
        if (memcmp(b->runs[i].size, size, sizeof b->runs[i].size) == 0)
            return true;
    return false;
}

/* Every size that is not there yet: the default's may be among them. */
static int add_sizes(bench_case *b, const plan *p) {
    const int *sizes = p->groups.count ? p->groups.numbers : usual_sizes;
    for (int i = 0; i < plan_sizes(p); i++)
        if (!has_size(b, &sizes[2 * i]) && add_run(b, p, &sizes[2 * i]))
            return -1;
    return 0;
}

static void take_error(run *r, const json_t *error) {
    int code = (int)json_integer_value(json_object_get(error, "code"));
    bool build = json_is_true(json_object_get(error, "build"));
    r->verdict = build ? VERDICT_COMPILE : code == FEELER_BAD_USAGE ? VERDICT_CONSTRAINTS : VERDICT_RUNTIME;
    snprintf(r->detail, sizeof r->detail, "%s", json_string_value(json_object_get(error, "text")));
}

static void take_render(bench_case *b, run *r, json_t *stats, const char *pixels, bool measured) {
    const json_t *seconds = json_object_get(stats, "seconds"), *group = json_object_get(stats, "work_group");
    if (!r->stats)
        r->compile = 1000 * json_number_value(json_object_get(seconds, "compile"));
    for (size_t i = 0; i < 2; i++)
        r->size[i] = (int)json_integer_value(json_array_get(group, i));
    r->forced = strcmp(json_string_value(json_object_get(stats, "work_group_from")), "forced") == 0;
    json_decref(r->stats);
    r->stats = json_incref(stats);
    if (measured) {
        r->kernel[r->repeats] = 1000 * json_number_value(json_object_get(seconds, "kernel"));
        r->wall[r->repeats++] = 1000 * json_number_value(json_object_get(seconds, "trace"));
    }
    if (!*b->pixels)
        snprintf(b->pixels, sizeof b->pixels, "%s", pixels);
    if (strcmp(b->pixels, pixels) == 0)
        return;
    r->verdict = VERDICT_CORRECTNESS;
    snprintf(r->detail, sizeof r->detail, "the picture is not the default's");
}

/* One render of one run. Returns an exit code: whether it was answered with an error. */
static int do_step(bench_case *b, run *r, child *c, bool measured) {
    json_t *reply = child_render(c, r);
    const json_t *error = json_object_get(reply, "error");
    r->finished = time(NULL);
    if (error) {
        take_error(r, error);
        child_end(c);
    } else if (reply) {
        take_render(b, r, json_object_get(reply, "stats"), json_string_value(json_object_get(reply, "pixels")),
                    measured);
    }
    int code = !error ? EXIT_DONE : r->verdict == VERDICT_CONSTRAINTS ? EXIT_USAGE : EXIT_FAILED;
    json_decref(reply);
    return code;
}

/* What a case is measured with. */
typedef struct bench {
    const plan *plan;
    const feeler_scene *scene;
    const feeler_settings *settings;
    child *children; /* one for each run */
} bench;

static void start_run(const bench *bench, bench_case *b, int index) {
    run *r = &b->runs[index];
    feeler_settings settings = *bench->settings;
    memcpy(settings.work_group, r->size, sizeof r->size);
    if (child_start(&bench->children[index], bench->scene, &settings, b->select, bench->plan->timeout, bench->children,
                    index) == 0)
        return;
    r->verdict = VERDICT_RUNTIME;
    snprintf(r->detail, sizeof r->detail, "no process could be started");
}

/* Every run's child renders once before any renders again: what else the machine does meets all alike. The default's
 * first render tells what size it has, and what no size can mend. */
static int take_turns(const bench *bench, bench_case *b, progress *progress) {
    const plan *p = bench->plan;
    const int steps = p->warm_up + p->repeat;
    if (add_run(b, p, NULL))
        return EXIT_FAILED;
    for (int step = 0; step < steps; step++)
        for (int i = 0; i < b->count; i++) {
            if (progress_step(progress, (double)(step * b->count + i) / (steps * (plan_sizes(p) + 1))))
                return EXIT_INTERRUPTED;
            if (step == 0)
                start_run(bench, b, i);
            if (!bench->children[i].pid)
                continue;
            int code = do_step(b, &b->runs[i], &bench->children[i], step >= p->warm_up);
            if (step > 0 || i > 0)
                continue;
            if (code != EXIT_DONE) {
                report_failure("%s: %s", b->scene, b->runs->detail);
                return code;
            }
            if (add_sizes(b, p))
                return EXIT_FAILED;
        }
    return progress_interrupted() ? EXIT_INTERRUPTED : EXIT_DONE;
}

/* Different pictures break a promise; no picture at all is no result. */
static int judge(const bench_case *b) {
    int pictures = 0, code = EXIT_DONE;
    for (int i = 0; i < b->count; i++) {
        const run *r = &b->runs[i];
        pictures += r->stats != NULL;
        if (r->verdict != VERDICT_CORRECTNESS)
            continue;
        report_failure("%s: the work group %dx%d makes another picture than the default", b->scene, r->size[0],
                       r->size[1]);
        code = EXIT_FAILED;
    }
    return pictures ? code : EXIT_FAILED;
}

int case_measure(bench_case *b, const plan *p, const feeler_scene *scene, const feeler_settings *settings,
                 progress *progress) {
    size_t most = (size_t)plan_sizes(p) + 1;
    const bench bench = {p, scene, settings, calloc(most, sizeof *bench.children)};
    int code = EXIT_FAILED;
    b->runs = calloc(most, sizeof *b->runs);
    if (bench.children && b->runs)
        code = take_turns(&bench, b, progress);
    else
        report_failure("out of memory");
    for (size_t i = 0; bench.children && i < most; i++)
        child_end(&bench.children[i]);
    free(bench.children);
    return code == EXIT_DONE ? judge(b) : code;
}

static int compare(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

times times_of(const double *values, int count) {
    double *sorted = count ? malloc((size_t)count * sizeof *sorted) : NULL;
    if (!sorted)
        return (times){0};
    memcpy(sorted, values, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, compare);
    const times t = {(sorted[(count - 1) / 2] + sorted[count / 2]) / 2, sorted[0], sorted[count - 1]};
    free(sorted);
    return t;
}
