/* cmd_summary.c - what a render took, in a few lines for people. */
#include "cmd.h"

#include <stdio.h>

static double number_at(const json_t *object, const char *key) {
    return json_number_value(json_object_get(object, key));
}

static json_int_t whole_at(const json_t *object, const char *key) {
    return json_integer_value(json_object_get(object, key));
}

static const char *text_at(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static int item(const json_t *object, const char *key, size_t index) {
    return (int)json_integer_value(json_array_get(json_object_get(object, key), index));
}

static void print_rays(const json_t *stats) {
    static const char *const kinds[] = {"eye", "reflection", "transmission", "shadow"};
    const json_t *rays = json_object_get(stats, "rays");
    double all = 0, trace = number_at(json_object_get(stats, "seconds"), "trace");
    fputs("  rays     ", stderr);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        all += number_at(rays, kinds[i]);
        fprintf(stderr, "%s%s %" JSON_INTEGER_FORMAT, i ? ", " : "", kinds[i], whole_at(rays, kinds[i]));
        if (i == 0)
            fprintf(stderr, " (hits %" JSON_INTEGER_FORMAT ")", whole_at(rays, "eye_hits"));
    }
    fputc('\n', stderr);
    if (trace > 0)
        fprintf(stderr, "  speed    %.3g Mrays/s\n", 1e-6 * all / trace);
}

static void print_seconds(const json_t *stats) {
    const char *key;
    json_t *value, *seconds = json_object_get(stats, "seconds");
    const char *between = "";
    fputs("  seconds  ", stderr);
    json_object_foreach(seconds, key, value) {
        if (json_is_null(value))
            continue;
        fprintf(stderr, "%s%s %.3f", between, key, json_number_value(value));
        between = ", ";
    }
    fputc('\n', stderr);
}

static void print_bound(const json_t *bound) {
    if (json_is_number(bound))
        fprintf(stderr, "; error by truncation at most %.3g\n", json_number_value(bound));
    else
        fputs("; error by truncation unbounded\n", stderr);
}

static void print_truncation(const json_t *stats) {
    const json_t *discarded = json_object_get(stats, "discarded_weight");
    fprintf(stderr, "  depth    deepest level %d of %d; discarded weight: greatest %.3g, mean %.3g",
            (int)whole_at(stats, "deepest_level"), (int)whole_at(stats, "depth"), number_at(discarded, "max"),
            number_at(discarded, "mean"));
    print_bound(json_object_get(stats, "truncation_bound"));
}

static void print_features(const json_t *stats) {
    size_t i;
    json_t *name, *features = json_object_get(stats, "features");
    fputs("  features", stderr);
    json_array_foreach(features, i, name) fprintf(stderr, " %s", json_string_value(name));
    fputc('\n', stderr);
}

/* The level's error apart from that of truncation. */
static void print_verification(const json_t *verification) {
    const json_t *d = json_object_get(verification, "precision"), *values = json_object_get(d, "values");
    fprintf(stderr, "  against reference, %d sample%s a pixel, %.3f s: precision, of linear values from 0 to 1\n",
            (int)whole_at(verification, "samples"), plural(whole_at(verification, "samples")),
            number_at(verification, "seconds"));
    fprintf(stderr, "    all    max %.3g, p99.9 %.3g, RMSE %.3g, FLIP mean %.3g\n", number_at(d, "max"),
            number_at(d, "p99.9"), number_at(d, "rmse"), number_at(d, "flip"));
    fprintf(stderr, "    flips  %" JSON_INTEGER_FORMAT " pixel%s off by more than 1/255, %.3g %%\n",
            whole_at(d, "flips"), plural(whole_at(d, "flips")), 100 * number_at(d, "share"));
    fprintf(stderr, "    values max %.3g, p99.9 %.3g, RMSE %.3g of the other pixels\n", number_at(values, "max"),
            number_at(values, "p99.9"), number_at(values, "rmse"));
    fputs("    truncation is apart", stderr);
    print_bound(json_object_get(verification, "truncation_bound"));
}

static void print_number(const json_t *number, const char *format, int width) {
    if (json_is_number(number))
        fprintf(stderr, format, width, json_number_value(number));
    else
        fprintf(stderr, "%*s", width, "-");
}

/* What was tried, and what was taken. */
static void print_tolerance(const json_t *stats) {
    size_t i;
    const json_t *tolerance = json_object_get(stats, "tolerance");
    json_t *one, *truth = json_object_get(tolerance, "truth"), *checked = json_object_get(tolerance, "checked");
    fprintf(
        stderr, "  tolerance %.3g %s: error %.3g (p99.9, linear values from 0 to 1) on ", number_at(tolerance, "asked"),
        json_is_true(json_object_get(tolerance, "reached")) ? "reached" : "NOT reached", number_at(tolerance, "error"));
    if (json_is_true(json_object_get(checked, "whole")))
        fputs("all pixels", stderr);
    else
        fprintf(stderr, "%d tiles of %dx%d pixels", (int)whole_at(checked, "tiles"), item(checked, "size", 0),
                item(checked, "size", 1));
    fprintf(stderr, ",\n    against reference with %d samples a pixel, itself known within %.2g; found in %.2f s\n",
            (int)whole_at(truth, "samples"), number_at(truth, "noise"), number_at(tolerance, "seconds"));
    fprintf(stderr, "    truncation is apart, for the truth has depth %d and cutoff %.3g",
            (int)whole_at(truth, "depth"), number_at(truth, "cutoff"));
    print_bound(json_object_get(stats, "truncation_bound"));
    fprintf(stderr, "    %-9s %7s %9s  error: %9s %10s, seconds on the proxy of %dx%d\n", "level", "samples", "cutoff",
            "picture", "proxy", item(tolerance, "proxy", 0), item(tolerance, "proxy", 1));
    json_array_foreach(json_object_get(tolerance, "candidates"), i, one) {
        const json_t *chosen = json_object_get(tolerance, "chosen");
        const bool mark = json_equal(json_object_get(one, "level"), json_object_get(chosen, "level")) &&
                          json_equal(json_object_get(one, "samples"), json_object_get(chosen, "samples")) &&
                          json_equal(json_object_get(one, "cutoff"), json_object_get(chosen, "cutoff"));
        fprintf(stderr, "  %c %-9s %7d %9.3g         ", mark ? '*' : ' ', text_at(one, "level"),
                (int)whole_at(one, "samples"), number_at(one, "cutoff"));
        print_number(json_object_get(one, "error"), "%*.3g", 9);
        print_number(json_object_get(one, "proxy_error"), "%*.3g", 11);
        print_number(json_object_get(one, "proxy_seconds"), "%*.4f", 9);
        fputc('\n', stderr);
    }
    fprintf(stderr, "    * %s\n", text_at(tolerance, "why"));
}

int summary_judge(const char *out, const char *stats_json) {
    json_t *stats = json_loads(stats_json, 0, NULL), *tolerance = json_object_get(stats, "tolerance");
    const bool reached = json_is_true(json_object_get(tolerance, "reached"));
    if (!reached)
        report_failure("%s: the tolerance of %g is not reached: the error is %.3g; %s", out,
                       number_at(tolerance, "asked"), number_at(tolerance, "error"), text_at(tolerance, "why"));
    json_decref(stats);
    return reached ? EXIT_DONE : EXIT_FAILED;
}

void summary_print(const char *scene_path, const char *out, const char *stats_json) {
    json_t *stats = json_loads(stats_json, 0, NULL);
    if (!stats)
        return;
    fprintf(stderr, "%s -> %s\n", scene_path, out);
    fprintf(stderr, "  picture  %dx%d, %d sample%s a pixel, %s\n", item(stats, "size", 0), item(stats, "size", 1),
            (int)whole_at(stats, "samples"), plural(whole_at(stats, "samples")), text_at(stats, "level"));
    fprintf(stderr, "  device   %s, work group %dx%d (%s), lanes %d\n", text_at(stats, "device"),
            item(stats, "work_group", 0), item(stats, "work_group", 1), text_at(stats, "work_group_from"),
            (int)whole_at(stats, "lanes"));
    print_rays(stats);
    print_seconds(stats);
    print_truncation(stats);
    print_features(stats);
    if (json_object_get(stats, "verification"))
        print_verification(json_object_get(stats, "verification"));
    if (json_object_get(stats, "tolerance"))
        print_tolerance(stats);
    json_decref(stats);
}
