/* fuzz_readers.c - feeds whatever libFuzzer thinks of to the readers of scenes: YAML, NFF, OBJ and PLY.
 *
 * A failure must be reported and leave nothing behind; the sanitizers see to the rest. The first byte chooses the reader
 * unless the input begins like a YAML scene, so that scene files can be the corpus as they are.
 */
#include "feeler.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/feeler-fuzz-XXXXXX";

static void remove_folder(void) {
    rmdir(folder);
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc, (void)argv;
    if (!mkdtemp(folder))
        abort();
    atexit(remove_folder);
    return 0;
}

/* Writes the data where a reader of this ending finds it. */
static void write_file(const char *path, const uint8_t *data, size_t size) {
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const endings[] = {"yaml", "nff", "obj", "ply"};
    size_t reader = 0;
    if (size && data[0] < 32) {
        reader = data[0] % (sizeof endings / sizeof *endings);
        data++, size--;
    } else if (size > 1 && data[0] == 'v' && data[1] <= ' ') {
        reader = 1;
    }
    char path[64];
    snprintf(path, sizeof path, "%s/scene.%s", folder, endings[reader]);
    write_file(path, data, size);

    static feeler_error error; /* large: kept from call to call, its log is not cleared */
    memset(&error, 0, offsetof(feeler_error, log) + 1);
    feeler_scene *scene = feeler_scene_load(path, &error);
    if (!scene && (error.code == FEELER_OK || !error.text[0]))
        abort(); /* a failure that says nothing */
    if (scene && error.code != FEELER_OK)
        abort(); /* a success that complains */
    feeler_scene_free(scene);
    unlink(path);
    return 0;
}
