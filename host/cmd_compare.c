/* cmd_compare.c - feeler compare: how far two pictures are apart, and whether that is too far. */
#include "cmd.h"
#include "options.h"

#include <stdio.h>
#include <string.h>

enum { MAX, P999, RMSE, SHARE, FLIP, FIGURES };

typedef struct comparison {
    const char *paths[2];
    double limits[FIGURES]; /* negative: none */
    const char *out;
    int map;
    bool json;
    feeler_image *images[2], *picture;
    feeler_difference difference;
    double factor;
} comparison;

static const char compare_notes[] =
    "B is the reference. Colours are compared as linear values from 0 to 1, alpha is not. A pixel's difference is the "
    "greatest\n"
    "of its channels'. The exit code is 1 where a figure is above its option. The difference picture is scaled by a\n"
    "power of two that is told; a FLIP map is grey and not scaled.";

static options_result check(comparison *c, bool map_is_given) {
    if (map_is_given && !c->out) {
        report_usage("compare", "--map needs --out, the picture to write");
        return OPTIONS_WRONG;
    }
    for (int i = 0; i < 2; i++)
        if (c->out && output_is_file(c->out, c->paths[i])) {
            report_usage("compare", "--out: %s is a picture that is compared", c->out);
            return OPTIONS_WRONG;
        }
    return OPTIONS_GO;
}

static options_result parse(comparison *c, int argc, char **argv) {
    int count, map = -1;
    const option options[] = {
        {"max", 0, OPTION_NUMBER, &c->limits[MAX], "E", NULL, "greatest difference allowed", 0, 1},
        {"p99.9", 0, OPTION_NUMBER, &c->limits[P999], "E", NULL, "greatest 99.9th percentile of the differences", 0, 1},
        {"rmse", 0, OPTION_NUMBER, &c->limits[RMSE], "E", NULL, "greatest root of the mean square", 0, 1},
        {"share", 0, OPTION_NUMBER, &c->limits[SHARE], "S", NULL, "greatest share of pixels off by more than 1/255", 0,
         1},
        {"flip", 0, OPTION_NUMBER, &c->limits[FLIP], "E", NULL, "greatest mean of FLIP", 0, 1},
        {"out", 'o', OPTION_TEXT, &c->out, "OUT", NULL, "write a picture of the difference", 0, 0},
        {"map", 0, OPTION_CHOICE, &map, "absolute|flip", "absolute", "what it shows", 0, 0},
        {"json", 0, OPTION_FLAG, &c->json, NULL, NULL, "print JSON", 0, 0},
        {0},
    };
    const command compare = {
        "compare", "A B",        "Measures how far two pictures are apart (.exr, .hdr, .png, .tif, .jpg).", options, 2,
        2,         compare_notes};
    options_result result = options_parse(&compare, argc, argv, &count);
    if (result != OPTIONS_GO)
        return result;
    memcpy(c->paths, argv, sizeof c->paths);
    c->map = map < 0 ? FEELER_MAP_ABSOLUTE : map;
    return check(c, map >= 0);
}

static int measure(comparison *c, feeler_error *error) {
    for (int i = 0; i < 2; i++)
        if (!(c->images[i] = feeler_image_load(c->paths[i], error)))
            return -1;
    if (feeler_compare(c->images[0], c->images[1], &c->difference, error))
        return -1;
    if (!c->out)
        return 0;
    c->picture = feeler_difference_image(c->images[0], c->images[1], c->map, &c->factor, error);
    return c->picture ? feeler_image_save(c->picture, c->out, NULL, error) : -1;
}

static void print_table(const comparison *c) {
    const feeler_difference *d = &c->difference;
    printf("%s against %s, %d x %d pixels, linear values from 0 to 1\n", c->paths[0], c->paths[1],
           feeler_image_width(c->images[0]), feeler_image_height(c->images[0]));
    printf("  max           %.6g\n  p99.9         %.6g\n  RMSE          %.6g\n", d->max, d->p999, d->rmse);
    printf("  over 1/255    %.4g %% of the pixels\n  FLIP mean     %.6g\n", 100 * d->share, d->flip);
    printf("apart\n  flips         %lld pixel%s off by more than 1/255\n", (long long)d->flips, plural(d->flips));
    printf("  values        max %.6g, p99.9 %.6g, RMSE %.6g of the other pixels\n", d->value_max, d->value_p999,
           d->value_rmse);
    if (d->nonfinite)
        printf("  not finite    %lld pixel%s, each counted as a difference of 1\n", (long long)d->nonfinite,
               plural(d->nonfinite));
    if (c->picture)
        printf("%s: the %s times %g\n", c->out, c->map == FEELER_MAP_FLIP ? "FLIP map" : "difference", c->factor);
}

static json_t *describe_picture(const comparison *c) {
    return json_pack("{s:s, s:s, s:f}", "file", c->out, "map", c->map == FEELER_MAP_FLIP ? "flip" : "absolute",
                     "factor", c->factor);
}

/* The library's figures, with the picture's name and factor. */
static int print_json(const comparison *c, feeler_error *error) {
    char *figures = feeler_difference_json(&c->difference, error);
    if (!figures)
        return -1;
    json_t *object = json_loads(figures, 0, NULL);
    feeler_free(figures);
    const bool whole = !c->picture || json_object_set_new(object, "picture", describe_picture(c)) == 0;
    char *text = whole && object ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(15)) : NULL;
    json_decref(object);
    if (!text) {
        report_failure("compare: out of memory, or a name that is no UTF-8, which JSON needs");
        return -1;
    }
    (void)report_json(text);
    return 0;
}

/* Says which figures are above their limits. */
static int judge(const comparison *c) {
    static const char *const names[FIGURES] = {"max", "p99.9", "rmse", "share", "flip"};
    const feeler_difference *d = &c->difference;
    const double values[FIGURES] = {d->max, d->p999, d->rmse, d->share, d->flip};
    int code = EXIT_DONE;
    for (int i = 0; i < FIGURES; i++)
        if (c->limits[i] >= 0 && !(values[i] <= c->limits[i])) {
            report_failure("%s is %.6g, above --%s %.6g", names[i], values[i], names[i], c->limits[i]);
            code = EXIT_FAILED;
        }
    return code;
}

static int run(comparison *c) {
    feeler_error error = {0};
    if (c->out && feeler_image_can_save(c->out, NULL, &error))
        return report_error(&error);
    if (measure(c, &error))
        return report_error(&error);
    if (!c->json)
        print_table(c);
    else if (print_json(c, &error))
        return error.code ? report_error(&error) : EXIT_FAILED;
    return judge(c);
}

int cmd_compare(int argc, char **argv) {
    comparison c = {.limits = {-1, -1, -1, -1, -1}};
    options_result parsed = parse(&c, argc, argv);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    int code = run(&c);
    for (int i = 0; i < 2; i++)
        feeler_image_free(c.images[i]);
    feeler_image_free(c.picture);
    return code;
}
