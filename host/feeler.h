/* feeler.h - the public interface of libfeeler, a Whitted ray tracer on OpenCL.
 *
 * The way of the data: load or build a scene, open a device, render, save the image.
 *
 * Every function that can fail takes a caller-owned feeler_error; it returns NULL or -1 on failure, fills the error once
 * (the first error wins) and leaves nothing allocated. Coordinates are right-handed and in the scene's own unit of
 * length; angles are degrees; colours are linear RGB. All strings are UTF-8. Functions may be called from any thread,
 * but one object only from one thread at a time.
 */
#ifndef FEELER_H
#define FEELER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__) && !defined(FEELER_CDEF)
#define FEELER_API __attribute__((visibility("default")))
#else
#define FEELER_API
#endif

/* ---- errors ---- */

typedef enum feeler_code {
    FEELER_OK = 0,
    FEELER_BAD_INPUT, /* a scene, mesh or setting is wrong */
    FEELER_BAD_USAGE, /* an argument of the call itself is wrong */
    FEELER_IO,        /* a file cannot be read or written */
    FEELER_OUT_OF_MEMORY,
    FEELER_DEVICE,     /* no OpenCL device, or an OpenCL call or kernel build failed */
    FEELER_INTERRUPTED /* the progress callback asked to stop */
} feeler_code;

/* Where and what is wrong. `source` is a file name, or the path of a key for a scene that came from a dict; line and
 * column count from 1, 0 where there is none. */
typedef struct feeler_error {
    int code;
    int line;
    int column;
    char source[512];
    char text[2048];
    char log[16384]; /* the compiler's log where a kernel failed to build, else empty */
} feeler_error;

/* Version of the library, such as "0.1.0". Static. */
FEELER_API const char *feeler_version(void);

/* "source:line:column: text", leaving out what is absent; never empty. Writes at most size bytes, always terminated. */
FEELER_API void feeler_error_format(const feeler_error *error, char *buffer, size_t size);

/* ---- nodes: a scene's structure, from YAML text or built by a caller ---- */

typedef struct feeler_node feeler_node;

/* Each returns a new node, or NULL when out of memory. A node owns what is added to it; free the root. */
FEELER_API feeler_node *feeler_node_map(void);
FEELER_API feeler_node *feeler_node_list(void);
FEELER_API feeler_node *feeler_node_text(const char *text);
FEELER_API feeler_node *feeler_node_number(double value);
/* Copies rows x columns doubles, row major; stands for a list of lists of numbers. */
FEELER_API feeler_node *feeler_node_array(const double *values, size_t rows, size_t columns);
/* 0, or -1 when out of memory or when `parent` cannot hold a child; takes `child` in either case. A list ignores `key`. */
FEELER_API int feeler_node_add(feeler_node *parent, const char *key, feeler_node *child);
FEELER_API void feeler_node_free(feeler_node *node);

/* ---- scenes ---- */

typedef struct feeler_scene feeler_scene;

/* Reads .yaml/.yml (native), .nff, or any mesh format that assimp reads; the ending decides. Validated. */
FEELER_API feeler_scene *feeler_scene_load(const char *path, feeler_error *error);
/* As a YAML file's root; relative file names are relative to `directory` (NULL: the working directory). Does not take
 * the node. */
FEELER_API feeler_scene *feeler_scene_from_node(const feeler_node *node, const char *directory, feeler_error *error);
FEELER_API void feeler_scene_free(feeler_scene *scene);
/* The warning at `index` (0 …), or NULL past the last. Owned by the scene. */
FEELER_API const char *feeler_scene_warning(const feeler_scene *scene, int index);

/* ---- settings ---- */

enum { FEELER_LEVEL_ANY = -1, FEELER_DRAFT, FEELER_STANDARD, FEELER_REFERENCE };

/* What may be had beside the picture, see docs/command-line.md: each is a bit. */
enum {
    FEELER_DEPTH = 1,
    FEELER_POSITION = 2,
    FEELER_NORMAL = 4,
    FEELER_OBJECT = 8,
    FEELER_MATERIAL = 16,
    FEELER_RAYS = 32,
    FEELER_DEEPEST = 64,
    FEELER_DISCARDED = 128,
    FEELER_MARGIN = 256
};

/* The bits of names with commas between them, or of "all"; -1 if there is an unknown one. */
FEELER_API int feeler_channels_parse(const char *names, feeler_error *error);

/* What a caller may set over the scene's own values. Start from feeler_settings_default. */
typedef struct feeler_settings {
    int width, height; /* pixels; 0: the scene's */
    int samples;       /* per pixel; 0: the scene's */
    double jitter;     /* 0 … 1; negative: the scene's */
    int depth;         /* greatest depth, the eye ray's being 1; 0: the scene's */
    double cutoff;     /* 0 … 1; negative: the scene's */
    int level;         /* FEELER_DRAFT, _STANDARD, _REFERENCE; _LEVEL_ANY for feeler_render_within alone */
    int region[4];     /* x0, y0, x1, y1, half open, pixels; all 0: the whole picture */
    int transparent;   /* 1: the background does not show, alpha is the coverage */
    int work_group[2]; /* x, y; 0: the one that is kept for this device and kernel (see feeler_tuned_keep), or chosen */
    int untuned;       /* 1: chosen without regard to what is kept */
    int unguarded;     /* 1: no limit but the device's own on a given work group; the driver may crash the process */
    int pixels[2];   /* x, y: of a work-item, whose samples go side by side; at most `lanes`, powers of two; 0: 1 x 1 */
    int lanes;       /* numbers side by side: 1, 2, 4, 8 or 16; 0: chosen */
    int tile;        /* pixels per launch; 0: adapted so that a launch takes a fraction of a second */
    int general;     /* 1: compile everything, not only what the scene needs (for tests) */
    int brute_force; /* 1: no tree (for tests) */
    int channels;    /* beside the picture: FEELER_DEPTH and the next, added */
} feeler_settings;

FEELER_API void feeler_settings_default(feeler_settings *settings);

/* ---- devices ---- */

typedef struct feeler_device feeler_device;

/* Opens a device. `select` is NULL or "" for the default (the first CPU device, else the first), a number as listed by
 * feeler_devices_json, or a part of a device's or platform's name. */
FEELER_API feeler_device *feeler_device_open(const char *select, feeler_error *error);
/* Uses a caller's context, device and queue (cl_context, cl_device_id, cl_command_queue as integers), as pyopencl's
 * int_ptr gives them. Retains them. */
FEELER_API feeler_device *feeler_device_wrap(intptr_t context, intptr_t device, intptr_t queue, feeler_error *error);
FEELER_API void feeler_device_close(feeler_device *device);
/* Owned by the device. */
FEELER_API const char *feeler_device_name(const feeler_device *device);
/* All platforms and devices, the default marked, as a JSON text to be freed with feeler_free. */
FEELER_API char *feeler_devices_json(feeler_error *error);

/* ---- rendering ---- */

typedef struct feeler_image feeler_image;

/* Called with 0 when the scene is packed and its trees are built, before kernels are compiled, and between launches, several
 * times a second: fraction done, 0 … 1. Nonzero stops the render. */
typedef int (*feeler_progress)(void *user, double fraction);

/* Renders. `progress` may be NULL. When progress asks to stop, the image so far is returned and error->code is
 * FEELER_INTERRUPTED; rows or tiles that are not done are transparent black. */
FEELER_API feeler_image *feeler_render(const feeler_scene *scene, const feeler_settings *settings,
                                       feeler_device *device, feeler_progress progress, void *user,
                                       feeler_error *error);
FEELER_API void feeler_image_free(feeler_image *image);

/* Size of the rendered region in pixels. */
FEELER_API int feeler_image_width(const feeler_image *image);
FEELER_API int feeler_image_height(const feeler_image *image);
/* RGBA, row major from the top left, linear, associated alpha (alpha is the share of samples that hit something, 1 for
 * hit; the background is in the colour unless settings.transparent). float32, or float64 at FEELER_REFERENCE. Owned by
 * the image. */
FEELER_API const void *feeler_image_pixels(const feeler_image *image);
FEELER_API int feeler_image_is_double(const feeler_image *image);
enum { FEELER_FLOAT32, FEELER_FLOAT64, FEELER_INT32 };

/* What was asked for beside the picture, row major from the top left, `components` numbers a pixel. */
typedef struct feeler_channel {
    const char *name; /* static */
    int components, type;
    const void *values; /* owned by the image */
} feeler_channel;

/* Fills in the channel at `index` (0 …); 0, or -1 past the last. */
FEELER_API int feeler_image_channel(const feeler_image *image, int index, feeler_channel *channel);
/* The name of the material with this id, "" if it has none; NULL past the last. Owned by the image, and there only if the
 * channel is. */
FEELER_API const char *feeler_image_material(const feeler_image *image, int id);
/* Statistics as JSON text (see docs/command-line.md); owned by the image. */
FEELER_API const char *feeler_image_stats_json(feeler_image *image, feeler_error *error);

/* Writes by the ending: .exr .hdr (linear float; .exr with the channels beside the picture), .png .tif .tiff (8 bit sRGB; 16 with sixteen_bit), .jpg. Written beside
 * its final name and renamed when whole. `alpha`: 0 RGB, 1 RGBA (an error for .jpg and .hdr). */
typedef struct feeler_save_options {
    int alpha;
    int sixteen_bit;
    int partial;  /* 1: the metadata says that the render was interrupted */
    int channels; /* 1: an error where the format keeps no channels beside the picture; .exr always does */
} feeler_save_options;

FEELER_API int feeler_image_save(feeler_image *image, const char *path, const feeler_save_options *options,
                                 feeler_error *error);
/* 0 if `path` can be written as asked (known ending, alpha allowed, not a directory, folder exists), else -1: ask before
 * rendering. */
FEELER_API int feeler_image_can_save(const char *path, const feeler_save_options *options, feeler_error *error);
/* Begins to load what writes pictures in a thread of its own: it takes a quarter of a second, which a render need not wait
 * for. 0, or -1 when it cannot be loaded, which may show only when it is asked again; `path` begins the message. Waits for
 * nothing. For one thread only, as the next. */
FEELER_API int feeler_image_load_begin(const char *path, feeler_error *error);
/* Ends that thread, before exit(). What it has not loaded is loaded when a picture is saved. */
FEELER_API void feeler_image_load_end(void);

/* ---- comparing ---- */

/* Reads .exr .hdr .png .tif .jpg and what else OpenImageIO reads. Whole numbers are sRGB and are made linear, unless the
 * file says that they are; alpha is associated, 1 where there is none. */
FEELER_API feeler_image *feeler_image_load(const char *path, feeler_error *error);
/* Copies width x height x channels doubles, row major from the top left: grey (1), RGB (3) or RGBA (4), as in
 * feeler_image_pixels. */
FEELER_API feeler_image *feeler_image_from_pixels(const double *values, int width, int height, int channels,
                                                  feeler_error *error);

/* How far a picture is from another. Colours alone count, as they are over black: linear, clamped to 0 … 1. A pixel's
 * difference is the greatest of its channels'; it is 1 where a channel of either picture is not finite. Pixels that differ by
 * more than 1/255 are flips: a decision went the other way. The values of all others are measured apart from them. */
typedef struct feeler_difference {
    int64_t pixels;
    int64_t nonfinite; /* pixels */
    double max;
    double p999;   /* 99.9th percentile of the pixels' differences, linear between neighbours */
    double rmse;   /* over pixels and channels */
    double flip;   /* mean of LDR-FLIP at 67 pixels per degree */
    int64_t flips; /* pixels */
    double share;  /* of the pixels that are flips */
    double value_max, value_p999, value_rmse; /* of the pixels that are not flips */
} feeler_difference;

/* 0, or -1 where the pictures have not the same size or show different regions. */
FEELER_API int feeler_compare(const feeler_image *image, const feeler_image *reference, feeler_difference *difference,
                              feeler_error *error);
/* The figures as JSON text, to be freed with feeler_free. */
FEELER_API char *feeler_difference_json(const feeler_difference *difference, feeler_error *error);

enum { FEELER_MAP_ABSOLUTE, FEELER_MAP_FLIP };

/* A picture of the difference: of each channel times *factor (0: a power of two by which all but a thousandth of the
 * pixels are below 1, put into *factor), or LDR-FLIP in grey, whose factor is 1 by default. */
FEELER_API feeler_image *feeler_difference_image(const feeler_image *image, const feeler_image *reference, int map,
                                                 double *factor, feeler_error *error);

/* Renders what a rendered image shows at FEELER_REFERENCE, with the same samples, depth and cutoff, and returns that picture:
 * what differs is the level's error of precision. The figures, and apart from them the bound of what truncation did, go
 * into the image's statistics as "verification". An image of FEELER_REFERENCE is an error. NULL also where progress asked to
 * stop. */
FEELER_API feeler_image *feeler_verify(const feeler_scene *scene, feeler_image *image, feeler_device *device,
                                       feeler_progress progress, void *user, feeler_error *error);

/* Renders with the cheapest level, samples and cutoff whose error is below `tolerance`, 0 … 1: the 99.9th percentile of
 * feeler_difference against FEELER_REFERENCE with many samples at the same depth. Of the settings those are kept that are given:
 * a level (FEELER_LEVEL_ANY: free), samples (0: free), a cutoff (negative: free). What was chosen, why and the error that was
 * measured is in the statistics as "tolerance"; where its "reached" is false, the picture is the best that was found.
 * Needs a device with double precision. Progress is that of the picture; it is 0 while settings are sought. */
FEELER_API feeler_image *feeler_render_within(const feeler_scene *scene, const feeler_settings *settings,
                                              double tolerance, feeler_device *device, feeler_progress progress,
                                              void *user, feeler_error *error);

/* ---- work groups that were found best ---- */

/* The file that keeps them: $FEELER_TUNED, else feeler/work-groups.yaml in $XDG_CONFIG_HOME or ~/.config. To be freed with
 * feeler_free; NULL where there is none, such as with an empty FEELER_TUNED. */
FEELER_API char *feeler_tuned_path(void);
/* 0, or -1 and what is wrong with the file and where. Renders do not fail by it: they leave it alone. */
FEELER_API int feeler_tuned_check(feeler_error *error);
/* Keeps the work group of a render's statistics (feeler_image_stats_json) for its device and its kernels' options. A file
 * that is damaged is not replaced. */
FEELER_API int feeler_tuned_keep(const char *stats_json, feeler_error *error);

/* ---- looking inside ---- */

/* What the scene contains, the features it needs, the kernel's options and memory, as JSON text to be freed with
 * feeler_free. */
FEELER_API char *feeler_scene_info_json(const feeler_scene *scene, const feeler_settings *settings,
                                        feeler_error *error);
/* All that the rays of pixel (x, y) do, from the kernels themselves, as JSON text (see docs/command-line.md) to be freed with
 * feeler_free. `sample`: the one to tell, from 0, or -1 for all. The settings' region, lanes, pixels and work group do not
 * count. */
FEELER_API char *feeler_pixel_json(const feeler_scene *scene, const feeler_settings *settings, feeler_device *device,
                                   int x, int y, int sample, feeler_error *error);
/* The same for people, from that JSON text: an indented text, and a drawing as SVG. To be freed with feeler_free. */
FEELER_API char *feeler_pixel_text(const char *pixel_json, feeler_error *error);
FEELER_API char *feeler_pixel_svg(const char *pixel_json, feeler_error *error);
/* The kernels' source, whole, with #line directives. Static. */
FEELER_API const char *feeler_kernel_source(void);
/* The build options for a scene and settings; with scene NULL, the general options (every feature) for the level and
 * lanes of the settings. To be freed with feeler_free. */
FEELER_API char *feeler_kernel_options(const feeler_scene *scene, const feeler_settings *settings, feeler_error *error);
FEELER_API void feeler_free(void *memory);

#ifdef __cplusplus
}
#endif

#endif
