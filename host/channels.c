/* channels.c */
#include "channels.h"

#include "image.h"
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const channel_kind channel_kinds[CHANNELS] = {
    [CHANNEL_DEPTH] = {"depth", 1, false, {"Z"}},
    [CHANNEL_POSITION] = {"position", 3, false, {"P.X", "P.Y", "P.Z"}},
    [CHANNEL_NORMAL] = {"normal", 3, false, {"N.X", "N.Y", "N.Z"}},
    [CHANNEL_OBJECT] = {"object", 1, true, {"object"}},
    [CHANNEL_MATERIAL] = {"material", 1, true, {"material"}},
    [CHANNEL_RAYS] = {"rays", 1, true, {"rays"}},
    [CHANNEL_DEEPEST] = {"deepest", 1, true, {"deepest"}},
    [CHANNEL_DISCARDED] = {"discarded", 3, false, {"discarded.R", "discarded.G", "discarded.B"}},
    [CHANNEL_MARGIN] = {"margin", 1, false, {"margin"}},
};

static size_t real_bytes(const feeler_image *image) {
    return image->is_double ? sizeof(double) : sizeof(float);
}

static void fill_unknown(feeler_image *image, int channel, size_t count) {
    void *plane = image->channels[channel];
    if (channel == CHANNEL_OBJECT || channel == CHANNEL_MATERIAL)
        memset(plane, 0xff, count * sizeof(int32_t)); /* -1 */
    for (size_t i = 0; channel == CHANNEL_DEPTH && i < count; i++) {
        if (image->is_double)
            ((double *)plane)[i] = INFINITY;
        else
            ((float *)plane)[i] = INFINITY;
    }
}

int channels_open(feeler_image *image, int bits, feeler_error *error) {
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (int i = 0; i < CHANNELS; i++) {
        const channel_kind *kind = &channel_kinds[i];
        if (!(bits >> i & 1))
            continue;
        const size_t number = kind->whole ? sizeof(int32_t) : real_bytes(image);
        image->channels[i] = calloc(count * (size_t)kind->components, number);
        if (!image->channels[i])
            return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the channel '%s'", kind->name);
        fill_unknown(image, i, count);
    }
    return 0;
}

void channels_close(feeler_image *image) {
    for (int i = 0; i < CHANNELS; i++)
        free(image->channels[i]);
    for (size_t i = 0; i < image->material_count; i++)
        free(image->materials[i]);
    free(image->materials);
}

int feeler_image_channel(const feeler_image *image, int index, feeler_channel *channel) {
    for (int i = 0; i < CHANNELS; i++) {
        const channel_kind *kind = &channel_kinds[i];
        if (!image->channels[i] || index-- > 0)
            continue;
        const int real = image->is_double ? FEELER_FLOAT64 : FEELER_FLOAT32;
        *channel =
            (feeler_channel){kind->name, kind->components, kind->whole ? FEELER_INT32 : real, image->channels[i]};
        return 0;
    }
    return -1;
}

const char *feeler_image_material(const feeler_image *image, int id) {
    return id >= 0 && (size_t)id < image->material_count ? image->materials[id] : NULL;
}
