/* cmd_bench_results.c - the results of a sweep as data: CSV, and JSON in the T4 schema that autotuners share. */
#include "cmd_bench.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *text_at(const json_t *stats, const char *key) {
    const char *text = json_string_value(json_object_get(stats, key));
    return text ? text : "";
}

static int whole_at(const json_t *stats, const char *key, size_t index) {
    const json_t *value = json_object_get(stats, key);
    return (int)json_integer_value(json_is_array(value) ? json_array_get(value, index) : value);
}

/* A run that did not render still has its case's settings: those of any run that did. */
static const json_t *stats_of(const bench_case *b, const run *r) {
    for (int i = 0; !r->stats && i < b->count; i++)
        if (b->runs[i].stats)
            return b->runs[i].stats;
    return r->stats;
}

static double correctness_of(const run *r) {
    return r->verdict == VERDICT_CORRECT ? 1 : 0;
}

/* ---- JSON ---- */

static void measure(json_t *list, const char *name, json_t *value, const char *unit) {
    json_array_append_new(list, json_pack("{s:s, s:o, s:s}", "name", name, "value", value, "unit", unit));
}

static void measure_times(json_t *list, const char *name, const double *values, int count) {
    static const char *const endings[] = {"", "_min", "_max"};
    const times t = times_of(values, count);
    const double numbers[] = {t.median, t.least, t.most};
    for (size_t i = 0; i < 3 && count; i++) {
        char whole_name[32];
        snprintf(whole_name, sizeof whole_name, "%s%s", name, endings[i]);
        measure(list, whole_name, json_real(numbers[i]), "ms");
    }
}

static json_t *list_of(const double *values, int count) {
    json_t *list = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(list, json_real(values[i]));
    return list;
}

static json_t *describe_configuration(const bench_case *b, const run *r) {
    const json_t *stats = stats_of(b, r);
    return json_pack("{s:i, s:i, s:s, s:s, s:s, s:i, s:i, s:i, s:i}", "work_group_x", r->size[0], "work_group_y",
                     r->size[1], "scene", b->scene, "device", text_at(stats, "device"), "level",
                     text_at(stats, "level"), "samples", whole_at(stats, "samples", 0), "width",
                     whole_at(stats, "size", 0), "height", whole_at(stats, "size", 1), "lanes",
                     whole_at(stats, "lanes", 0));
}

static json_t *describe_measurements(const run *r) {
    json_t *list = json_array();
    measure_times(list, "time", r->kernel, r->repeats);
    measure_times(list, "wall", r->wall, r->repeats);
    measure(list, "default", json_integer(r->is_default), "");
    measure(list, "forced", json_integer(r->forced), "");
    if (r->stats)
        measure(list, "features", json_incref(json_object_get(r->stats, "features")), "");
    if (*r->detail)
        measure(list, "detail", json_string(r->detail), "");
    return list;
}

static json_t *describe_run(const bench_case *b, const run *r) {
    char stamp[32];
    struct tm utc;
    strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&r->finished, &utc));
    return json_pack("{s:s, s:o, s:[s], s:{s:f, s:o}, s:s, s:f, s:o}", "timestamp", stamp, "configuration",
                     describe_configuration(b, r), "objectives", "time", "times", "compilation_time", r->compile,
                     "runtimes", list_of(r->kernel, r->repeats), "invalidity", verdict_names[r->verdict], "correctness",
                     correctness_of(r), "measurements", describe_measurements(r));
}

char *results_json(const bench_case *cases, int count) {
    json_t *results = json_array();
    for (int i = 0; i < count; i++)
        for (int k = 0; k < cases[i].count; k++)
            if (json_array_append_new(results, describe_run(&cases[i], &cases[i].runs[k]))) {
                json_decref(results);
                return NULL;
            }
    json_t *root = json_pack("{s:s, s:o}", "schema_version", "1.0.0", "results", results);
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(root);
    return text;
}

/* ---- CSV ---- */

/* A field in quotes, with a quote inside doubled (RFC 4180). */
static void print_quoted(FILE *file, const char *text) {
    fputc('"', file);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', file);
        fputc(*text, file);
    }
    fputc('"', file);
}

/* Three fields, empty where there are no times. */
static void print_times(FILE *file, const double *values, int count) {
    const times t = times_of(values, count);
    if (count)
        fprintf(file, "%.9g,%.9g,%.9g,", t.median, t.least, t.most);
    else
        fputs(",,,", file);
}

static void print_run(FILE *file, const bench_case *b, const run *r) {
    const json_t *stats = stats_of(b, r);
    print_quoted(file, b->scene);
    fputc(',', file);
    print_quoted(file, text_at(stats, "device"));
    fprintf(file, ",%s,%d,%d,%d,%d,%d,%d,%d,%d,%s,%g,%d,", text_at(stats, "level"), whole_at(stats, "samples", 0),
            whole_at(stats, "size", 0), whole_at(stats, "size", 1), whole_at(stats, "lanes", 0), r->size[0], r->size[1],
            r->is_default, r->forced, verdict_names[r->verdict], correctness_of(r), r->repeats);
    print_times(file, r->kernel, r->repeats);
    print_times(file, r->wall, r->repeats);
    fprintf(file, "%.9g,", r->compile);
    print_quoted(file, r->detail);
    fputc('\n', file);
}

char *results_csv(const bench_case *cases, int count) {
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file)
        return NULL;
    fputs(
        "scene,device,level,samples,width,height,lanes,work_group_x,work_group_y,default,forced,invalidity,correctness,"
        "repeats,time_ms,time_min_ms,time_max_ms,wall_ms,wall_min_ms,wall_max_ms,compilation_ms,detail\n",
        file);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < cases[i].count; k++)
            print_run(file, &cases[i], &cases[i].runs[k]);
    bool whole = !ferror(file);
    if (fclose(file) || !whole) {
        free(text);
        return NULL;
    }
    text[size - 1] = '\0'; /* output_write_text ends the last line */
    return text;
}
