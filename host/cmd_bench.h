/* cmd_bench.h - a sweep over work groups: cases (a scene, device, level and number of samples), each with a run for
 * every size, each run in a process of its own. All times are milliseconds where nothing else is said. */
#ifndef FEELER_CMD_BENCH_H
#define FEELER_CMD_BENCH_H

#include "cmd.h"
#include "options.h"
#include "progress.h"

#include <sys/types.h>
#include <time.h>

/* What is asked for. */
typedef struct plan {
    option_list groups, devices, levels, samples;
    int size[2]; /* pixels; 0: the scene's */
    int repeat, warm_up;
    double timeout; /* seconds for a run */
    const char *json, *csv;
    bool keep, quiet;
    bool table; /* for people is printed: stdout has no other use */
} plan;

/* The words of "invalidity" in the T4 schema, in this order. */
typedef enum verdict {
    VERDICT_CORRECT,
    VERDICT_TIMEOUT,     /* took longer than a run may */
    VERDICT_COMPILE,     /* its kernels do not build */
    VERDICT_RUNTIME,     /* crashed, or failed in another way */
    VERDICT_CORRECTNESS, /* the picture is another than the default's */
    VERDICT_CONSTRAINTS  /* device or kernel does not take the size */
} verdict;

extern const char *const verdict_names[];

typedef struct run {
    int size[2];     /* 0: the default, until it is known */
    bool is_default; /* what render chooses where nothing is kept */
    verdict verdict;
    char detail[512];      /* what went wrong */
    double *kernel, *wall; /* one for each repeat that came back; owned */
    int repeats;
    double compile; /* of the first render; not in the other times */
    bool forced;    /* render refuses the size: a driver may crash */
    json_t *stats;  /* of the last render; owned; NULL: there is none */
    time_t finished;
} run;

typedef struct bench_case {
    const char *scene, *select; /* as the user writes them; borrowed */
    char pixels[17]; /* the bits that every run must have: a hash of the default's; "": there is no picture */
    run *runs;       /* the default first; owned */
    int count;
} bench_case;

typedef struct times {
    double median, least, most;
} times;

/* ---- cmd_bench_case.c ---- */

/* Measures every size. `settings` are complete but for the work group. Returns an exit code; what went wrong for the
 * case as a whole is said on stderr. */
int case_measure(bench_case *bench_case, const plan *plan, const feeler_scene *scene, const feeler_settings *settings,
                 progress *progress);
void case_free(bench_case *bench_case);
/* How many sizes the plan asks for beside the default. */
int plan_sizes(const plan *plan);
/* Of a run's kernel or wall times; zeros where there are none. */
times times_of(const double *values, int count);

/* ---- cmd_bench_child.c ---- */

typedef struct child {
    pid_t pid;          /* 0: none */
    int socket;         /* to and from it */
    double limit, left; /* seconds that it may take, altogether and still */
} child;

/* Forks a child that renders when it is asked. It opens the device itself: this process must not have touched OpenCL.
 * `others` are its siblings, whose sockets it closes. -1: said on stderr. */
int child_start(child *child, const feeler_scene *scene, const feeler_settings *settings, const char *select,
                double timeout, const struct child *others, int other_count);
/* Asks for one render and waits. Returns {"stats": …, "pixels": hash} or {"error": {"code": …, "text": …, "build": …}},
 * or NULL when the child crashed, was too slow or is interrupted: then it has ended, and the run says why. */
json_t *child_render(child *child, run *run);
void child_end(child *child);

/* ---- cmd_bench_table.c, cmd_bench_results.c ---- */

/* The case for people, on stdout. */
void table_print(const bench_case *bench_case, const plan *plan);
/* All runs as text to be freed; NULL: out of memory. */
char *results_csv(const bench_case *cases, int count);
/* In Kernel Tuner's schema for results, T4 1.0.0. */
char *results_json(const bench_case *cases, int count);

/* ---- cmd_bench_best.c ---- */

/* The run of a case whose size is best: of the least median, but the default where none is faster than each of its
 * repeats, which may well be chance. NULL: no run is correct. */
const run *best_of(const bench_case *bench_case);
/* Keeps the best size of every device and kernel. Returns an exit code. */
int best_keep(const bench_case *cases, int count);

#endif
