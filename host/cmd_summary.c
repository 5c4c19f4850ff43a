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

static void print_truncation(const json_t *stats) {
    const json_t *discarded = json_object_get(stats, "discarded_weight");
    const json_t *bound = json_object_get(stats, "truncation_bound");
    fprintf(stderr, "  depth    deepest level %d of %d; discarded weight: greatest %.3g, mean %.3g",
            (int)whole_at(stats, "deepest_level"), (int)whole_at(stats, "depth"), number_at(discarded, "max"),
            number_at(discarded, "mean"));
    if (json_is_number(bound))
        fprintf(stderr, "; error by truncation at most %.3g\n", json_number_value(bound));
    else
        fputs("; error by truncation unbounded\n", stderr);
}

static void print_features(const json_t *stats) {
    size_t i;
    json_t *name, *features = json_object_get(stats, "features");
    fputs("  features", stderr);
    json_array_foreach(features, i, name) fprintf(stderr, " %s", json_string_value(name));
    fputc('\n', stderr);
}

void summary_print(const char *scene_path, const char *out, const char *stats_json) {
    json_t *stats = json_loads(stats_json, 0, NULL);
    if (!stats)
        return;
    fprintf(stderr, "%s -> %s\n", scene_path, out);
    fprintf(stderr, "  picture  %dx%d, %d sample%s a pixel, %s\n", item(stats, "size", 0), item(stats, "size", 1),
            (int)whole_at(stats, "samples"), whole_at(stats, "samples") == 1 ? "" : "s", text_at(stats, "level"));
    fprintf(stderr, "  device   %s, work group %dx%d (%s), lanes %d\n", text_at(stats, "device"),
            item(stats, "work_group", 0), item(stats, "work_group", 1), text_at(stats, "work_group_from"),
            (int)whole_at(stats, "lanes"));
    print_rays(stats);
    print_seconds(stats);
    print_truncation(stats);
    print_features(stats);
    json_decref(stats);
}
