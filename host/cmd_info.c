/* cmd_info.c - feeler info: what a scene contains. The keys are the library's; here they are only set in columns. */
#include "cmd.h"
#include "options.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

enum { COLUMN = 28 };

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

static void print_bytes(double bytes) {
    static const char *const units[] = {"bytes", "KiB", "MiB", "GiB"};
    int unit = 0;
    for (; bytes >= 1024 && unit < 3; unit++)
        bytes /= 1024;
    printf(unit ? "%.1f %s" : "%.0f %s", bytes, units[unit]);
}

static void print_scalar(const json_t *value, bool bytes) {
    if (bytes && json_is_number(value))
        print_bytes(json_number_value(value));
    else if (json_is_string(value))
        fputs(json_string_value(value), stdout);
    else if (json_is_integer(value))
        printf("%" JSON_INTEGER_FORMAT, json_integer_value(value));
    else if (json_is_real(value))
        printf("%.6g", json_real_value(value));
    else
        fputs(json_is_true(value) ? "yes" : json_is_false(value) ? "no" : "none", stdout);
}

/* The key, and the way to the column where its value begins unless lines of its own follow. */
static void print_label(const char *key, int indent, bool heading) {
    int length = printf("%*s", indent, "");
    for (; *key; key++, length++)
        putchar(*key == '_' ? ' ' : *key);
    if (heading)
        putchar('\n');
    else
        printf("%*s", length < COLUMN ? COLUMN - length : 1, "");
}

static void print_entry(const char *key, const json_t *value, int indent, bool bytes);

static void print_list(const char *key, const json_t *list, int indent, bool bytes) {
    size_t i;
    json_t *item;
    const char *between = "";
    bool deep = json_is_object(json_array_get(list, 0)) || json_is_array(json_array_get(list, 0));
    print_label(key, indent, deep);
    if (json_array_size(list) == 0)
        fputs("none", stdout);
    json_array_foreach(list, i, item) {
        char number[24];
        snprintf(number, sizeof number, "%zu", i + 1);
        if (deep) {
            print_entry(number, item, indent + 2, bytes);
        } else {
            fputs(between, stdout);
            print_scalar(item, bytes);
            between = ", ";
        }
    }
    if (!deep)
        putchar('\n');
}

static void print_entry(const char *key, const json_t *value, int indent, bool bytes) {
    const char *inner;
    json_t *child;
    bytes = bytes || ends_with(key, "_bytes");
    if (json_is_array(value)) {
        print_list(key, value, indent, bytes);
        return;
    }
    bool heading = json_object_size(value) > 0;
    print_label(key, indent, heading);
    if (!heading) {
        if (json_is_object(value))
            fputs("none", stdout);
        else
            print_scalar(value, bytes);
        putchar('\n');
    }
    json_object_foreach((json_t *)value, inner, child) print_entry(inner, child, indent + 2, bytes);
}

static int print_info(const char *path, const feeler_settings *settings, bool as_json) {
    feeler_error error = {0};
    const char *warning, *key;
    json_t *value;
    feeler_scene *scene = feeler_scene_load(path, &error);
    if (!scene)
        return report_error(&error);
    for (int i = 0; (warning = feeler_scene_warning(scene, i)); i++)
        report_warning(warning);
    report_tuned();
    char *text = feeler_scene_info_json(scene, settings, &error);
    feeler_scene_free(scene);
    if (!text)
        return report_error(&error);
    if (as_json)
        return report_json(text);

    json_t *root = json_loads(text, 0, NULL);
    feeler_free(text);
    if (!root) {
        report_failure("%s: out of memory", path);
        return EXIT_FAILED;
    }
    json_object_foreach(root, key, value) print_entry(key, value, 0, false);
    json_decref(root);
    return EXIT_DONE;
}

int cmd_info(int argc, char **argv) {
    feeler_settings settings;
    bool as_json = false;
    int count;
    feeler_settings_default(&settings);
    const option options[] = {
        {"json", 0, OPTION_FLAG, &as_json, NULL, NULL, "as JSON", 0, 0},
        {"size", 's', OPTION_SIZE, &settings.width, "WxH", "the scene's", "as it would be rendered with", 1, 65536},
        {"samples", 0, OPTION_WHOLE, &settings.samples, "N", "the scene's", "the same", 1, 4096},
        {"depth", 0, OPTION_WHOLE, &settings.depth, "N", "the scene's", "the same", 1, 256},
        {"level", 0, OPTION_CHOICE, &settings.level, "draft|standard|reference", "standard", "the same", 0, 0},
        {0},
    };
    const command info = {
        "info",  "SCENE", "Shows what a scene contains, which features it needs, the kernel's options and memory.",
        options, 1,       1,
        NULL};
    options_result parsed = options_parse(&info, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    return print_info(argv[0], &settings, as_json);
}
