/* record.c - has a pixel traced with notes, in buffers that are made larger until all fit. */
#include "record.h"

#include <stdlib.h>
#include <string.h>

enum { NOTE_ARRAYS = 6, MOST_RAYS = 50000 /* nobody reads more, and they double with every level of depth */ };

/* In the order of record_pixel's parameters; two to each of `count`. */
static const struct {
    size_t element; /* bytes, in double */
    bool is_real;
} kinds[NOTE_ARRAYS] = {
    {sizeof(ray_note), true},    {sizeof(ray_tags), false},     {sizeof(light_note), true},
    {sizeof(light_tags), false}, {sizeof(crossing_note), true}, {sizeof(crossing_tags), false},
};

static uint32_t count_of(uint4 count, int array) {
    return array < 2 ? count.x : array < 4 ? count.y : count.z;
}

static size_t element_size(const job *j, int array) {
    return kinds[array].element / (kinds[array].is_real && real_size(j) == sizeof(float) ? 2 : 1);
}

static void release(cl_mem *buffers, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (buffers[i])
            clReleaseMemObject(buffers[i]);
    memset(buffers, 0, count * sizeof *buffers);
}

/* Behind the last place is one for what has no room. */
static int open_buffers(const job *j, uint4 room, cl_mem *buffers, feeler_error *error) {
    for (int i = 0; i < NOTE_ARRAYS; i++) {
        cl_int status;
        const size_t size = ((size_t)count_of(room, i) + 1) * element_size(j, i);
        buffers[i] = clCreateBuffer(j->device->context, CL_MEM_READ_WRITE, size, NULL, &status);
        if (status != CL_SUCCESS)
            return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the %u rays of a pixel", (unsigned)room.x);
    }
    return 0;
}

static int read_buffer(const job *j, cl_mem buffer, void *to, size_t size, feeler_error *error) {
    cl_int status =
        size ? clEnqueueReadBuffer(j->device->queue, buffer, CL_TRUE, 0, size, to, 0, NULL, NULL) : CL_SUCCESS;
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueReadBuffer", status);
}

/* Widens in place the floats that the first half of the room holds. */
static void widen(void *numbers, size_t count) {
    double *doubles = numbers;
    for (size_t i = count; i-- > 0;) {
        float one;
        memcpy(&one, (const char *)numbers + i * sizeof one, sizeof one);
        doubles[i] = one;
    }
}

/* Reals of the kernel's kind, as doubles. */
static int read_reals(const job *j, cl_mem buffer, void *to, size_t count, feeler_error *error) {
    if (read_buffer(j, buffer, to, count * real_size(j), error) < 0)
        return -1;
    if (real_size(j) == sizeof(float))
        widen(to, count);
    return 0;
}

static void *read_array(const job *j, cl_mem buffer, int array, size_t count, feeler_error *error) {
    const size_t size = count * kinds[array].element;
    void *read = malloc(size + 1);
    if (!read) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the rays of a pixel");
        return NULL;
    }
    int status = kinds[array].is_real ? read_reals(j, buffer, read, size / sizeof(double), error)
                                      : read_buffer(j, buffer, read, size, error);
    if (status == 0)
        return read;
    free(read);
    return NULL;
}

static int read_notes(const job *j, const cl_mem *buffers, notes *n, feeler_error *error) {
    void *arrays[NOTE_ARRAYS] = {0};
    int status = 0;
    for (int i = 0; status == 0 && i < NOTE_ARRAYS; i++)
        status = (arrays[i] = read_array(j, buffers[i], i, count_of(n->count, i), error)) ? 0 : -1;
    n->rays = arrays[0];
    n->ray_tags = arrays[1];
    n->lights = arrays[2];
    n->light_tags = arrays[3];
    n->crossings = arrays[4];
    n->crossing_tags = arrays[5];
    const result *results = j->slots[0].results;
    if (status == 0)
        status = read_reals(j, results[RESULT_PIXELS].buffer, &n->pixel, 4, error);
    if (status == 0)
        status = read_buffer(j, results[RESULT_RAYS].buffer, &n->sent, sizeof n->sent, error);
    if (status == 0 && sends_rays(j))
        status = read_reals(j, results[RESULT_UNSENT].buffer, &n->unsent, 4, error);
    return status;
}

int take_notes(const job *j, notes *n, feeler_error *error) {
    uint4 room = {64, 256, 64, 0};
    cl_mem buffers[NOTE_ARRAYS] = {0};
    cl_int status;
    memset(n, 0, sizeof *n);
    cl_mem counts = clCreateBuffer(j->device->context, CL_MEM_WRITE_ONLY, sizeof room, NULL, &status);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clCreateBuffer", status);
    int result;
    bool fits;
    do { /* twice at most: the second time there is room for as many as there were */
        release(buffers, NOTE_ARRAYS);
        result = open_buffers(j, room, buffers, error);
        if (result == 0)
            result = launch_notes(j, buffers, NOTE_ARRAYS, room, counts, error);
        if (result == 0)
            result = read_buffer(j, counts, &n->count, sizeof n->count, error);
        if (result == 0 && n->count.x > MOST_RAYS)
            result =
                fail(error, FEELER_BAD_USAGE,
                     "the pixel has %u rays, at most %d can be told: less depth, a greater cutoff or fewer samples "
                     "make it fewer",
                     (unsigned)n->count.x, MOST_RAYS);
        fits = n->count.x <= room.x && n->count.y <= room.y && n->count.z <= room.z;
        room = n->count;
    } while (result == 0 && !fits);
    if (result == 0)
        result = read_notes(j, buffers, n, error);
    release(buffers, NOTE_ARRAYS);
    clReleaseMemObject(counts);
    if (result < 0)
        notes_free(n);
    return result;
}

void notes_free(notes *n) {
    free(n->rays);
    free(n->ray_tags);
    free(n->lights);
    free(n->light_tags);
    free(n->crossings);
    free(n->crossing_tags);
    memset(n, 0, sizeof *n);
}
