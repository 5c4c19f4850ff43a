/* cmd_pixel.c - feeler pixel: all that the rays of one pixel do. */
#include "cmd.h"
#include "options.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct question {
    const char *scene;
    int x, y, sample;
    feeler_settings settings;
    const char *select, *svg;
    bool as_json;
} question;

/* Whole numbers from 0 on. */
static int read_coordinate(const char *text, int *value) {
    char *end;
    errno = 0;
    long number = strtol(text, &end, 10);
    if (*text >= '0' && *text <= '9' && *end == '\0' && errno == 0 && number <= INT_MAX) {
        *value = (int)number;
        return 0;
    }
    report_usage("pixel", "'%s' is no coordinate of a pixel: a whole number from 0 on, from the top left", text);
    return -1;
}

/* The text on standard output, unless that has the drawing. */
static int tell(const question *q, char *json) {
    feeler_error error = {0};
    const bool drawn_only = q->svg && strcmp(q->svg, "-") == 0;
    char *text = NULL, *svg = q->svg ? feeler_pixel_svg(json, &error) : NULL;
    int code = EXIT_FAILED;
    if (q->svg && !svg)
        code = report_error(&error);
    else if (svg && output_write_text(q->svg, svg))
        code = EXIT_FAILED;
    else if (drawn_only)
        code = EXIT_DONE;
    else if (q->as_json)
        code = output_write_text("-", json) ? EXIT_FAILED : EXIT_DONE;
    else if (!(text = feeler_pixel_text(json, &error)))
        code = report_error(&error);
    else
        code = output_write_text("-", text) ? EXIT_FAILED : EXIT_DONE;
    feeler_free(text);
    feeler_free(svg);
    return code;
}

static int ask(const question *q) {
    feeler_error error = {0};
    const char *warning;
    if (q->svg && output_check_text(q->svg, q->scene))
        return EXIT_FAILED;
    feeler_scene *scene = feeler_scene_load(q->scene, &error);
    if (!scene)
        return report_error(&error);
    for (int i = 0; (warning = feeler_scene_warning(scene, i)); i++)
        report_warning(warning);
    feeler_device *device = feeler_device_open(q->select, &error);
    char *json = device ? feeler_pixel_json(scene, &q->settings, device, q->x, q->y, q->sample, &error) : NULL;
    int code = json ? tell(q, json) : report_error(&error);
    feeler_free(json);
    feeler_device_close(device);
    feeler_scene_free(scene);
    return code;
}

int cmd_pixel(int argc, char **argv) {
    question q = {.sample = -1};
    feeler_settings *s = &q.settings;
    int count;
    feeler_settings_default(s);
    const option options[] = {
        {"json", 0, OPTION_FLAG, &q.as_json, NULL, NULL, "as JSON", 0, 0},
        {"svg", 0, OPTION_TEXT, &q.svg, "FILE.svg", NULL, "draw it, too; - is stdout, and then only that", 0, 0},
        {"sample", 0, OPTION_WHOLE, &q.sample, "N", "all", "only this one, from 0 on", 0, 4095},
        {"size", 's', OPTION_SIZE, &s->width, "WxH", "the scene's", "pixels of the whole picture", 1, 65536},
        {"samples", 0, OPTION_WHOLE, &s->samples, "N", "the scene's", "samples a pixel", 1, 4096},
        {"jitter", 0, OPTION_NUMBER, &s->jitter, "0..1", "the scene's", "how far samples leave their cells' centres", 0,
         1},
        {"depth", 0, OPTION_WHOLE, &s->depth, "N", "the scene's", "greatest depth of a ray, the eye ray's being 1", 1,
         256},
        {"cutoff", 0, OPTION_NUMBER, &s->cutoff, "W", "the scene's", "rays of less weight are not sent", 0, 1},
        {"level", 0, OPTION_CHOICE, &s->level, "draft|standard|reference", "standard", "how exact", 0, 0},
        {"device", 0, OPTION_TEXT, &q.select, "SELECT", "the first CPU",
         "number or part of a name, see 'feeler devices'", 0, 0},
        {0},
    };
    const command pixel = {"pixel",
                           "SCENE X Y",
                           "Tells all that the rays of one pixel do, as they are traced for a picture.",
                           options,
                           3,
                           3,
                           "X and Y count from 0 at the top left. A ray is told with all that it meets, each term of "
                           "the light there, what\n"
                           "blocks the feelers, and what is sent on; then in words why the pixel has its colour."};
    options_result parsed = options_parse(&pixel, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    q.scene = argv[0];
    if (read_coordinate(argv[1], &q.x) || read_coordinate(argv[2], &q.y))
        return EXIT_USAGE;
    if (q.svg && strcmp(q.svg, "-") != 0 && !output_ends_in(q.svg, ".svg")) {
        report_usage("pixel", "--svg: the drawing of a pixel is an .svg file, not '%s'", q.svg);
        return EXIT_USAGE;
    }
    return ask(&q);
}
