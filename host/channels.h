/* channels.h - what may be had beside a picture: names, what a pixel has of each, and their planes in an image. */
#ifndef FEELER_CHANNELS_H
#define FEELER_CHANNELS_H

#include "feeler.h"

#include <stdbool.h>
#include <stddef.h>

/* Bit i of feeler_settings.channels is channel i. */
enum {
    CHANNEL_DEPTH,
    CHANNEL_POSITION,
    CHANNEL_NORMAL,
    CHANNEL_OBJECT,
    CHANNEL_MATERIAL,
    CHANNEL_RAYS,
    CHANNEL_DEEPEST,
    CHANNEL_DISCARDED,
    CHANNEL_MARGIN,
    CHANNELS
};
enum { FEELER_ALL_CHANNELS = (1 << CHANNELS) - 1 };

typedef struct channel_kind {
    const char *name;
    int components;       /* numbers a pixel */
    bool whole;           /* whole numbers of 32 bits, else reals of the image's kind */
    const char *layer[3]; /* names of the components in an EXR file */
} channel_kind;

extern const channel_kind channel_kinds[CHANNELS];

/* Room for the channels of these bits, as of pixels that are not rendered: nothing is met, and nothing known. */
int channels_open(feeler_image *image, int bits, feeler_error *error);
void channels_close(feeler_image *image);

#endif
