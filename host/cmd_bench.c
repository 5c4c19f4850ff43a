/* cmd_bench.c - feeler bench: which work group is fastest? Sweeps over scenes, devices, levels, samples and sizes. */
#include "cmd_bench.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct sweep {
    plan plan;
    bench_case *cases; /* room for all */
    int count;
} sweep;

static const char bench_notes[] =
    "The sweep is every scene with every device, level and number of samples, and with each work group beside the\n"
    "one that 'render' chooses, the default. A work group runs in a process of its own: one that crashes or takes too\n"
    "long is a row of the table. The processes take turns, one render each, so that what else the machine does meets\n"
    "all alike. Kernel times are those of the device's own events, from START to END; no compiling is in them.";

static options_result parse(plan *p, int argc, char **argv, int *count) {
    const option options[] = {
        {"work-groups", 0, OPTION_LIST, &p->groups, "XxY", "1x1,4x4,8x8,16x4,16x16,64x1", "beside the default's", 1,
         INT_MAX},
        {"device", 0, OPTION_LIST, &p->devices, "SELECT", "the first CPU",
         "numbers or parts of names, see 'feeler devices'", 0, 0},
        {"level", 0, OPTION_LIST, &p->levels, "draft|standard|reference", "standard", "how exact", 0, 0},
        {"samples", 0, OPTION_LIST, &p->samples, "N", "the scene's", "samples a pixel", 1, 4096},
        {"size", 's', OPTION_SIZE, p->size, "WxH", "the scene's", "pixels", 1, 65536},
        {"repeat", 0, OPTION_WHOLE, &p->repeat, "N", "5", "renders that are measured", 1, 10000},
        {"warm-up", 0, OPTION_WHOLE, &p->warm_up, "N", "1", "renders before them", 0, 10000},
        {"timeout", 0, OPTION_NUMBER, &p->timeout, "SECONDS", "300", "what a work group may take altogether", 0.001,
         1e6},
        {"json", 0, OPTION_TEXT, &p->json, "FILE", NULL, "write results in Kernel Tuner's T4 schema; - is stdout", 0,
         0},
        {"csv", 0, OPTION_TEXT, &p->csv, "FILE", NULL, "write a table with commas; - is stdout", 0, 0},
        {"save", 0, OPTION_FLAG, &p->keep, NULL, NULL, "keep the best for each device and kernel: 'render' uses it", 0,
         0},
        {"quiet", 'q', OPTION_FLAG, &p->quiet, NULL, NULL, "no progress and no table", 0, 0},
        {0},
    };
    const command bench = {"bench",    "SCENE…", "Measures how fast scenes are rendered with different work groups.",
                           options,    1,        INT_MAX,
                           bench_notes};
    return options_parse(&bench, argc, argv, count);
}

static int check_kept(void) {
    feeler_error error = {0};
    char *path = feeler_tuned_path();
    bool known = path != NULL;
    feeler_free(path);
    if (known)
        return feeler_tuned_check(&error) ? report_error(&error) : EXIT_DONE;
    report_failure("--save: there is no file to keep work groups in (%s)",
                   getenv("FEELER_TUNED") ? "FEELER_TUNED is empty" : "neither XDG_CONFIG_HOME nor HOME is set");
    return EXIT_FAILED;
}

/* Tells, before any time is spent, what cannot be written. */
static int check_outputs(plan *p, int count, char **scenes) {
    bool json = p->json && strcmp(p->json, "-") == 0, csv = p->csv && strcmp(p->csv, "-") == 0;
    if (p->json && p->csv && strcmp(p->json, p->csv) == 0) {
        report_usage("bench", "--json and --csv cannot both be %s", json ? "stdout" : p->json);
        return EXIT_USAGE;
    }
    p->table = !p->quiet && !json && !csv;
    for (int i = 0; i < count; i++)
        if ((p->json && output_check_text(p->json, scenes[i])) || (p->csv && output_check_text(p->csv, scenes[i])))
            return EXIT_FAILED;
    return p->keep ? check_kept() : EXIT_DONE;
}

/* The value at an index of a list, or the fallback where the list is empty. */
static int number_at(const option_list *list, int index, int fallback) {
    return list->count ? list->numbers[index] : fallback;
}

static int ways(const option_list *list) {
    return list->count ? list->count : 1;
}

static int run_case(sweep *s, const char *path, const feeler_scene *scene, const int index[3]) {
    const plan *p = &s->plan;
    bench_case *b = &s->cases[s->count++];
    feeler_settings settings;
    progress progress;
    feeler_settings_default(&settings);
    settings.untuned = settings.unguarded = 1;
    settings.width = p->size[0];
    settings.height = p->size[1];
    settings.level = number_at(&p->levels, index[1], FEELER_STANDARD);
    settings.samples = number_at(&p->samples, index[2], 0);
    *b = (bench_case){.scene = path, .select = p->devices.count ? p->devices.texts[index[0]] : NULL};
    progress_begin(&progress, path, !p->quiet);
    int code = case_measure(b, p, scene, &settings, &progress);
    progress_end(&progress);
    if (b->count > 1 && p->table && code != EXIT_INTERRUPTED)
        table_print(b, p);
    return code;
}

static int run_scene(sweep *s, const char *path) {
    feeler_error error = {0};
    const char *warning;
    feeler_scene *scene = feeler_scene_load(path, &error);
    if (!scene)
        return report_error(&error);
    for (int i = 0; (warning = feeler_scene_warning(scene, i)); i++)
        report_warning(warning);
    int code = EXIT_DONE, index[3];
    for (index[0] = 0; index[0] < ways(&s->plan.devices); index[0]++)
        for (index[1] = 0; index[1] < ways(&s->plan.levels); index[1]++)
            for (index[2] = 0; index[2] < ways(&s->plan.samples) && code != EXIT_INTERRUPTED; index[2]++) {
                int one = run_case(s, path, scene, index);
                code = one == EXIT_DONE ? code : one;
            }
    feeler_scene_free(scene);
    return code;
}

static int write_results(const sweep *s, const char *path, char *(*make)(const bench_case *, int)) {
    char *text = make(s->cases, s->count);
    int status = text ? output_write_text(path, text) : -1;
    if (!text)
        report_failure("out of memory");
    free(text);
    return status ? EXIT_FAILED : EXIT_DONE;
}

/* One case that fails does not stop the others, and what came out is written. */
static int run_sweep(sweep *s, int scene_count, char **scenes) {
    const plan *p = &s->plan;
    int code = EXIT_DONE;
    for (int i = 0; i < scene_count; i++) {
        int one = run_scene(s, scenes[i]);
        if (one == EXIT_INTERRUPTED) {
            report_note("interrupted, no results were written");
            return one;
        }
        if (one != EXIT_DONE)
            code = scene_count == 1 ? one : EXIT_FAILED;
    }
    if ((p->json && write_results(s, p->json, results_json)) || (p->csv && write_results(s, p->csv, results_csv)))
        code = EXIT_FAILED;
    if (p->keep && best_keep(s->cases, s->count))
        code = EXIT_FAILED;
    return code;
}

int cmd_bench(int argc, char **argv) {
    sweep s = {.plan = {.groups.kind = OPTION_SIZE,
                        .devices.kind = OPTION_TEXT,
                        .levels.kind = OPTION_CHOICE,
                        .samples.kind = OPTION_WHOLE,
                        .repeat = 5,
                        .warm_up = 1,
                        .timeout = 300}};
    plan *p = &s.plan;
    int count = 0;
    options_result parsed = parse(p, argc, argv, &count);
    int code = parsed == OPTIONS_GO ? check_outputs(p, count, argv) : parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    if (parsed == OPTIONS_GO && code == EXIT_DONE) {
        size_t most = (size_t)count * (size_t)ways(&p->devices) * (size_t)ways(&p->levels) * (size_t)ways(&p->samples);
        s.cases = calloc(most, sizeof *s.cases);
        progress_catch_signals();
        code = s.cases ? run_sweep(&s, count, argv) : EXIT_FAILED;
        if (!s.cases)
            report_failure("out of memory");
    }
    for (int i = 0; i < s.count; i++)
        case_free(&s.cases[i]);
    free(s.cases);
    options_list_free(&p->groups);
    options_list_free(&p->devices);
    options_list_free(&p->levels);
    options_list_free(&p->samples);
    return code;
}
