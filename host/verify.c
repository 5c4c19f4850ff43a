/* verify.c - how far a picture is from its own at level reference. */
#include "difference.h"
#include "scene.h"

#include <string.h>

/* What the picture was rendered with, at level reference. Work group and lanes never change a picture: they are chosen. */
static feeler_settings reference_settings(const feeler_image *image) {
    const render_stats *s = &image->stats;
    feeler_settings settings;
    feeler_settings_default(&settings);
    settings.level = FEELER_REFERENCE;
    settings.width = s->width;
    settings.height = s->height;
    settings.samples = s->samples;
    settings.jitter = s->jitter;
    settings.depth = s->depth;
    settings.cutoff = s->cutoff;
    settings.transparent = image->transparent;
    const int region[4] = {image->x0, image->y0, image->x0 + image->width, image->y0 + image->height};
    memcpy(settings.region, region, sizeof region);
    return settings;
}

/* Precision and truncation apart: they are errors of different kinds, and only one of them is measured. */
static json_t *describe(const feeler_difference *d, const render_stats *reference) {
    return json_pack("{s:s, s:i, s:o, s:{s:f, s:f}, s:o, s:f}", "against", level_name(reference->level), "samples",
                     reference->samples, "precision", describe_difference(d), "discarded_weight", "max",
                     reference->discarded_max, "mean", reference->discarded_mean, "truncation_bound",
                     describe_bound(reference->truncation_bound), "seconds", reference->total);
}

feeler_image *feeler_verify(const feeler_scene *scene, feeler_image *image, feeler_device *device,
                            feeler_progress progress, void *user, feeler_error *error) {
    feeler_difference d;
    if (!image->options || image->stats.level == FEELER_REFERENCE) {
        fail(error, FEELER_BAD_USAGE,
             image->options ? "a picture of level reference has none to be verified against; choose draft or standard"
                            : "this picture was not rendered: it cannot be verified");
        return NULL;
    }
    const feeler_settings settings = reference_settings(image);
    feeler_error own = {0};
    feeler_image *reference = feeler_render(scene, &settings, device, progress, user, &own);
    if (reference && own.code == 0 && feeler_compare(image, reference, &d, &own) == 0 &&
        image_report(image, "verification", describe(&d, &reference->stats), &own) == 0)
        return reference;
    *error = own;
    feeler_image_free(reference);
    return NULL;
}
