/* render_bits.c - renders SCENE at LEVEL (0 … 2) through the public interface, to FILE: the pixels as they are in memory. */
#include "feeler.h"

#include <stdio.h>
#include <stdlib.h>

static int write_pixels(const feeler_image *image, const char *path) {
    size_t size = feeler_image_is_double(image) ? sizeof(double) : sizeof(float);
    size_t count = (size_t)feeler_image_width(image) * (size_t)feeler_image_height(image) * 4;
    FILE *file = fopen(path, "wb");
    if (!file)
        return 1;
    size_t written = fwrite(feeler_image_pixels(image), size, count, file);
    return fclose(file) != 0 || written != count;
}

int main(int argc, char **argv) {
    if (argc != 4)
        return 2;
    feeler_error error = {0};
    feeler_settings settings;
    feeler_settings_default(&settings);
    settings.level = atoi(argv[2]);
    feeler_scene *scene = feeler_scene_load(argv[1], &error);
    feeler_device *device = scene ? feeler_device_open(NULL, &error) : NULL;
    feeler_image *image = device ? feeler_render(scene, &settings, device, NULL, NULL, &error) : NULL;
    int failed = image ? write_pixels(image, argv[3]) : 1;
    if (error.code) {
        char text[1024];
        feeler_error_format(&error, text, sizeof text);
        fprintf(stderr, "%s\n", text);
    }
    feeler_image_free(image);
    feeler_device_close(device);
    feeler_scene_free(scene);
    return failed;
}
