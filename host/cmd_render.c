/* cmd_render.c - feeler render: scenes in, pictures out. */
#include "cmd.h"
#include "options.h"
#include "progress.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct job {
    feeler_settings settings;
    feeler_save_options save;
    const char *out, *stats, *select, *channels;
    bool alpha, quiet, verify;
    double tolerance;      /* 0: none */
    feeler_device *device; /* opened when the first scene is ready for it */
    bool hopeless;         /* what went wrong would go wrong for every scene */
} job;

static const char render_notes[] =
    "OUT's ending tells the format: .exr and .hdr keep linear floating point values, .png and .tif 8 or 16 bits\n"
    "and .jpg 8 bits in sRGB. With several scenes OUT (and FILE) must contain {name}, which stands for the scene's\n"
    "file name without folder and ending. Channels beside the picture: depth, position, normal, object, material,\n"
    "rays, deepest, discarded, margin. Ctrl-C saves what is done as OUT with .partial before its ending.";

static int parse_channels(job *j) {
    feeler_error error = {0};
    j->settings.channels = feeler_channels_parse(j->channels, &error);
    j->save.channels = 1;
    if (j->settings.channels < 0)
        report_usage("render", "--channels: %s", error.text);
    return j->settings.channels;
}

static options_result parse(job *j, int argc, char **argv, int *scene_count) {
    feeler_settings *s = &j->settings;
    const option options[] = {
        {"out", 'o', OPTION_TEXT, &j->out, "OUT", NULL, "the picture to write", 0, 0},
        {"size", 's', OPTION_SIZE, &s->width, "WxH", "the scene's", "pixels", 1, 65536},
        {"samples", 0, OPTION_WHOLE, &s->samples, "N", "the scene's", "samples a pixel", 1, 4096},
        {"jitter", 0, OPTION_NUMBER, &s->jitter, "0..1", "the scene's", "how far samples leave their cells' centres", 0,
         1},
        {"depth", 0, OPTION_WHOLE, &s->depth, "N", "the scene's", "greatest depth of a ray, the eye ray's being 1", 1,
         256},
        {"cutoff", 0, OPTION_NUMBER, &s->cutoff, "W", "the scene's", "rays of less weight are not sent", 0, 1},
        {"level", 0, OPTION_CHOICE, &s->level, "draft|standard|reference", "standard", "how exact", 0, 0},
        {"tolerance", 0, OPTION_NUMBER, &j->tolerance, "E", NULL,
         "find the cheapest level, samples and cutoff whose error is below E", 1e-9, 1},
        {"verify", 0, OPTION_FLAG, &j->verify, NULL, NULL, "measure the error against level reference", 0, 0},
        {"region", 0, OPTION_REGION, s->region, "X0,Y0,X1,Y1", "all", "render only these pixels, half open", 0, 0},
        {"alpha", 0, OPTION_FLAG, &j->alpha, NULL, NULL, "leave the background transparent", 0, 0},
        {"bits", 0, OPTION_CHOICE, &j->save.sixteen_bit, "8|16", "8", "of .png and .tif", 0, 0},
        {"channels", 0, OPTION_TEXT, &j->channels, "NAME,…", NULL, "also write these into .exr, or 'all' of them", 0,
         0},
        {"device", 0, OPTION_TEXT, &j->select, "SELECT", "the first CPU",
         "number or part of a name, see 'feeler devices'", 0, 0},
        {"work-group", 0, OPTION_SIZE, s->work_group, "XxY", "kept or chosen", "work-items of a work-group", 1, 65536},
        {"pixels", 0, OPTION_SIZE, s->pixels, "XxY", "1x1", "pixels of a work-item, traced side by side", 1, 16},
        {"stats", 0, OPTION_TEXT, &j->stats, "FILE.json", NULL, "write rays, times and settings as JSON; - is stdout",
         0, 0},
        {"quiet", 'q', OPTION_FLAG, &j->quiet, NULL, NULL, "no progress and no summary", 0, 0},
        {0},
    };
    const command render = {
        "render", "SCENE…",    "Renders scenes (.yaml, .nff, or meshes such as .obj, .ply, .stl, .gltf).", options, 1,
        INT_MAX,  render_notes};
    options_result result = options_parse(&render, argc, argv, scene_count);
    if (result != OPTIONS_GO)
        return result;
    s->transparent = j->save.alpha = j->alpha;
    if (j->channels && parse_channels(j) < 0)
        return OPTIONS_WRONG;
    const char *wrong = !j->out ? "--out is missing: name the picture to write, such as -o picture.png" : NULL;
    if (j->verify && s->level == FEELER_REFERENCE)
        wrong = "--verify compares with level reference: choose draft or standard";
    if (j->verify && j->tolerance > 0)
        wrong = "--tolerance measures the error already: leave --verify away";
    if (s->level == FEELER_LEVEL_ANY && !(j->tolerance > 0))
        s->level = FEELER_STANDARD;
    if (!wrong)
        return OPTIONS_GO;
    report_usage("render", "%s", wrong);
    return OPTIONS_WRONG;
}

/* Tells, before any time is spent, what cannot end well. Returns an exit code. */
static int check_names(const job *j, int count, char **scenes) {
    const struct { const char *option, *pattern; } outputs[] = {{"out", j->out}, {"stats", j->stats}};
    if (j->stats && strcmp(j->out, j->stats) == 0) {
        report_usage("render", "--out and --stats cannot both be %s", j->out);
        return EXIT_USAGE;
    }
    for (size_t i = 0; i < 2 && count > 1; i++)
        if (outputs[i].pattern && !strstr(outputs[i].pattern, "{name}")) {
            report_usage("render", "--%s: with several scenes '%s' must contain {name}", outputs[i].option,
                         outputs[i].pattern);
            return EXIT_USAGE;
        }
    for (int a = 0; a < count; a++)
        for (int b = 0; b < a; b++) {
            char *name_a = output_scene_name(scenes[a]), *name_b = output_scene_name(scenes[b]);
            bool same = name_a && name_b && strcmp(name_a, name_b) == 0;
            free(name_a);
            free(name_b);
            if (!same)
                continue;
            report_usage("render", "'%s' and '%s' would be written under the same name", scenes[b], scenes[a]);
            return EXIT_USAGE;
        }
    return EXIT_DONE;
}

/* The names that one scene's results get. */
typedef struct outputs {
    char *name, *out, *stats; /* owned; stats may be NULL */
} outputs;

static void outputs_free(outputs *o) {
    free(o->name);
    free(o->out);
    free(o->stats);
    *o = (outputs){0};
}

static int outputs_make(outputs *o, const job *j, const char *scene) {
    *o = (outputs){.name = output_scene_name(scene)};
    if (o->name)
        o->out = output_expand(j->out, o->name);
    if (o->name && j->stats)
        o->stats = output_expand(j->stats, o->name);
    if (o->name && o->out && (o->stats || !j->stats))
        return 0;
    report_failure("out of memory");
    outputs_free(o);
    return -1;
}

static int outputs_make_partial(outputs *o) {
    char *out = output_partial(o->out), *stats = o->stats ? output_partial(o->stats) : NULL;
    if (!out || (o->stats && !stats)) {
        report_failure("out of memory");
        free(out);
        free(stats);
        return -1;
    }
    free(o->out);
    free(o->stats);
    o->out = out;
    o->stats = stats;
    return 0;
}

/* A render that is shown, and stopped as soon as it is known that its picture cannot be written. What writes pictures is
 * loaded from the first step on and not before: the loader of libraries works for one at a time, and the device's driver
 * and the trees' threads are among those who would wait. */
typedef struct watch {
    progress progress;
    const char *name; /* of the picture: until it is under way another may be shown */
    const char *out;
    feeler_error error;
} watch;

static int watch_step(void *user, double fraction) {
    watch *w = user;
    if (fraction > 0)
        w->progress.name = w->name;
    return feeler_image_load_begin(w->out, &w->error) ? 1 : progress_step(&w->progress, fraction);
}

/* Renders once more at level reference; only the figures are kept, in the image's statistics. */
static int verify(const job *j, const feeler_scene *scene, const outputs *o, feeler_image *image) {
    feeler_error error = {0};
    watch watch = {.name = "verify", .out = o->out};
    progress_begin(&watch.progress, watch.name, !j->quiet);
    feeler_image *reference = feeler_verify(scene, image, j->device, watch_step, &watch, &error);
    progress_end(&watch.progress);
    feeler_image_free(reference);
    if (reference)
        return EXIT_DONE;
    if (error.code != FEELER_INTERRUPTED)
        return report_error(&error);
    report_note("interrupted, %s is whole but not verified", o->out);
    return EXIT_DONE;
}

/* Loads and traces. Returns an exit code; EXIT_INTERRUPTED may come with an image, as may a failure to verify it. */
static int trace(job *j, const char *path, const outputs *o, feeler_image **image) {
    feeler_error error = {0};
    watch watch = {.name = o->name, .out = o->out};
    int code = EXIT_FAILED;
    const char *warning;
    feeler_scene *scene = feeler_scene_load(path, &error);
    if (!scene)
        return report_error(&error);
    for (int i = 0; (warning = feeler_scene_warning(scene, i)); i++)
        report_warning(warning);
    if (progress_interrupted()) {
        feeler_scene_free(scene);
        return EXIT_INTERRUPTED;
    }

    if (!j->device)
        j->device = feeler_device_open(j->select, &error);
    j->hopeless = !j->device;
    if (j->hopeless)
        goto failed;
    progress_begin(&watch.progress, j->tolerance > 0 ? "tolerance" : o->name, !j->quiet);
    *image = j->tolerance > 0
                 ? feeler_render_within(scene, &j->settings, j->tolerance, j->device, watch_step, &watch, &error)
                 : feeler_render(scene, &j->settings, j->device, watch_step, &watch, &error);
    progress_end(&watch.progress);
    j->hopeless = watch.error.code != 0;
    if (j->hopeless)
        error = watch.error;
    /* A driver's compiler may fail by the signal. */
    bool stopped = error.code == FEELER_INTERRUPTED || (!*image && progress_interrupted());
    if (j->hopeless || (!*image && !stopped))
        goto failed;
    code = stopped ? EXIT_INTERRUPTED : j->verify ? verify(j, scene, o, *image) : EXIT_DONE;
    feeler_scene_free(scene);
    if (!stopped)
        return code;
    /* Ctrl-C while the kernel was compiled: the first tile alone is not worth a file. */
    if (!watch.progress.under_way) {
        feeler_image_free(*image);
        *image = NULL;
    }
    return EXIT_INTERRUPTED;
failed:
    code = report_error(&error);
    feeler_image_free(*image);
    *image = NULL;
    feeler_scene_free(scene);
    return code;
}

/* Saves the picture and what is known about it. */
static int save(const job *j, const char *scene, feeler_image *image, const outputs *o, bool partial) {
    feeler_error error = {0};
    feeler_save_options options = j->save;
    options.partial = partial;
    if (feeler_image_save(image, o->out, &options, &error))
        return report_error(&error);
    const char *stats = feeler_image_stats_json(image, &error);
    if (!stats)
        return report_error(&error);
    if (!j->quiet)
        summary_print(scene, o->out, stats);
    if (o->stats && output_write_text(o->stats, stats))
        return EXIT_FAILED;
    return j->tolerance > 0 ? summary_judge(o->out, stats) : EXIT_DONE;
}

static int render_one(job *j, const char *scene) {
    feeler_error error = {0};
    feeler_image *image = NULL;
    outputs o;
    if (outputs_make(&o, j, scene))
        return EXIT_FAILED;

    int code = EXIT_FAILED;
    if (feeler_image_can_save(o.out, &j->save, &error)) {
        code = report_error(&error);
        j->hopeless = code == EXIT_USAGE;
        goto done;
    }
    if (o.stats && output_check_text(o.stats, scene))
        goto done;
    code = trace(j, scene, &o, &image);
    if (code == EXIT_INTERRUPTED) {
        if (!image || outputs_make_partial(&o))
            report_note("interrupted, nothing was written");
        else if (save(j, scene, image, &o, true) == EXIT_DONE)
            report_note("interrupted, the finished part is in %s", o.out);
    } else if (image) {
        const int saved = save(j, scene, image, &o, false);
        code = saved == EXIT_DONE ? code : saved;
    }
done:
    feeler_image_free(image);
    outputs_free(&o);
    return code;
}

/* One scene that fails does not stop the others. */
static int render_all(job *j, int count, char **scenes) {
    int code = EXIT_DONE;
    for (int i = 0; i < count && !j->hopeless; i++) {
        int one = render_one(j, scenes[i]);
        if (progress_interrupted())
            return EXIT_INTERRUPTED;
        if (one != EXIT_DONE)
            code = count == 1 || j->hopeless ? one : EXIT_FAILED;
    }
    return code;
}

int cmd_render(int argc, char **argv) {
    job j = {0};
    int count = 0;
    feeler_settings_default(&j.settings);
    j.settings.level = FEELER_LEVEL_ANY;
    options_result parsed = parse(&j, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    int code = check_names(&j, count, argv);
    if (code != EXIT_DONE)
        return code;

    if (!j.settings.work_group[0])
        report_tuned();
    progress_catch_signals();
    code = render_all(&j, count, argv);
    feeler_image_load_end();
    feeler_device_close(j.device);
    return code;
}
