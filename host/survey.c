/* survey.c - what lies beside the picture: a second launch for each tile, of a program of its own (survey.cl), where a channel
 * asks for what a render does not tell. */
#include "job.h"

#include <stdlib.h>
#include <string.h>

int open_channels(job *j, const feeler_scene *scene, feeler_error *error) {
    feeler_image *image = j->image;
    if (channels_open(image, j->settings.channels, error) < 0)
        return -1;
    if (!image->channels[CHANNEL_MATERIAL])
        return 0;
    image->materials = calloc(scene->material_count + 1, sizeof *image->materials);
    for (size_t i = 0; image->materials && i < scene->material_count; i++) {
        const char *name = scene->materials[i].name;
        image->materials[i] = strdup(name ? name : "");
        if (!image->materials[i])
            break;
        image->material_count++;
    }
    return image->material_count == scene->material_count ? 0 : fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
}

/* One ray at a time, each a number wide: what it does is then written as for one, and gives the bits of any lanes. */
static feeler_settings survey_settings(const feeler_settings *s) {
    feeler_settings lone = *s;
    lone.lanes = lone.pixels[0] = lone.pixels[1] = 1;
    lone.work_group[0] = lone.work_group[1] = 0;
    lone.untuned = 1;
    return lone;
}

int open_survey(job *j, feeler_error *error) {
    const int render_knows = FEELER_RAYS | FEELER_DEEPEST | FEELER_DISCARDED;
    if (!(j->settings.channels & ~render_knows))
        return 0;
    const feeler_settings lone = survey_settings(&j->settings);
    static const char survey[] = " -DSURVEY=1", margin[] = " -DMARGIN=1";
    char *plain = program_options(&lone, j->needs, error), *options;
    if (!plain)
        return -1;
    options = realloc(plain, strlen(plain) + sizeof survey + sizeof margin);
    if (!options) {
        free(plain);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the kernel's options");
    }
    strcat(options, survey);
    if (j->settings.channels & FEELER_MARGIN)
        strcat(options, margin);
    group_origin chosen;
    const int status =
        program_build(&j->survey, j->device, options, "survey", error) < 0
            ? -1
            : choose_work_group(j->device, &j->survey, &lone, j->needs, options, j->survey_group, &chosen, error);
    free(options);
    return status;
}

int start_survey(const job *j, slot *s, feeler_error *error) {
    static const int pixel[2] = {1, 1};
    if (bind_frame(j, s, j->survey.render, RESULT_SURFACES, RESULTS, error) < 0)
        return -1;
    return enqueue_tile(j, s, j->survey.render, pixel, j->survey_group, &s->launched, &s->surveyed, error);
}

/* A result's number, of floats or doubles. */
static double real_at(const job *j, const slot *s, int result, size_t i) {
    const void *reals = s->results[result].host;
    return j->image->is_double ? ((const double *)reals)[i] : (double)((const float *)reals)[i];
}

static void set_real(const feeler_image *image, int channel, size_t i, double value) {
    if (image->is_double)
        ((double *)image->channels[channel])[i] = value;
    else
        ((float *)image->channels[channel])[i] = (float)value;
}

static void set_whole(const feeler_image *image, int channel, size_t i, uint32_t value) {
    ((int32_t *)image->channels[channel])[i] = (int32_t)value;
}

/* What a render tells: `from` is the pixel's place in the tile, `to` that in the image. */
static void take_tree(const job *j, const slot *s, size_t from, size_t to) {
    const feeler_image *image = j->image;
    if (image->channels[CHANNEL_RAYS]) {
        const uint4 rays = ((const uint4 *)s->results[RESULT_RAYS].host)[from];
        set_whole(image, CHANNEL_RAYS, to, (uint32_t)j->settings.samples + rays.x + rays.y + rays.z);
    }
    if (image->channels[CHANNEL_DEEPEST])
        set_whole(image, CHANNEL_DEEPEST, to, sends_rays(j) ? (uint32_t)real_at(j, s, RESULT_UNSENT, 4 * from + 3) : 1);
    for (size_t k = 0; image->channels[CHANNEL_DISCARDED] && sends_rays(j) && k < 3; k++)
        set_real(image, CHANNEL_DISCARDED, 3 * to + k, real_at(j, s, RESULT_UNSENT, 4 * from + k));
}

/* Two real4 of a survey: point and distance, normal and margin; and two numbers, of the primitive and of the material. */
static void take_surface(const job *j, const slot *s, size_t from, size_t to) {
    const feeler_image *image = j->image;
    const int32_t *ids = (const int32_t *)s->results[RESULT_IDS].host + 2 * from;
    const vec3 o = j->packed.origin;
    const double origin[3] = {o.x, o.y, o.z};
    if (image->channels[CHANNEL_DEPTH])
        set_real(image, CHANNEL_DEPTH, to, real_at(j, s, RESULT_SURFACES, 8 * from + 3));
    for (size_t k = 0; image->channels[CHANNEL_POSITION] && ids[0] >= 0 && k < 3; k++)
        set_real(image, CHANNEL_POSITION, 3 * to + k, origin[k] + real_at(j, s, RESULT_SURFACES, 8 * from + k));
    for (size_t k = 0; image->channels[CHANNEL_NORMAL] && k < 3; k++)
        set_real(image, CHANNEL_NORMAL, 3 * to + k, real_at(j, s, RESULT_SURFACES, 8 * from + 4 + k));
    if (image->channels[CHANNEL_MARGIN])
        set_real(image, CHANNEL_MARGIN, to, real_at(j, s, RESULT_SURFACES, 8 * from + 7));
    if (image->channels[CHANNEL_OBJECT] && ids[0] >= 0)
        set_whole(image, CHANNEL_OBJECT, to, (uint32_t)packed_object_number(&j->packed, (uint32_t)ids[0]));
    if (image->channels[CHANNEL_MATERIAL])
        set_whole(image, CHANNEL_MATERIAL, to, (uint32_t)ids[1]);
}

void take_channels(job *j, const slot *s) {
    const tile *t = &s->tile;
    if (!j->settings.channels)
        return;
    for (size_t from = 0; from < tile_pixels(t); from++) {
        const size_t width = (size_t)(t->x1 - t->x0), x = (size_t)(t->x0 - j->image->x0) + from % width,
                     y = (size_t)(t->y0 - j->image->y0) + from / width, to = y * (size_t)j->image->width + x;
        take_tree(j, s, from, to);
        if (j->survey.program)
            take_surface(j, s, from, to);
    }
}
