/* device_list.c - finds the OpenCL devices and describes them. */
#include "device_list.h"

#include "scene.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

enum { PLATFORM_NOT_FOUND_KHR = -1001 };

/* Drivers end texts with spaces and may use any encoding; JSON and terminals want neither. */
static void make_plain(char *text) {
    size_t start = strspn(text, " \t\n");
    memmove(text, text + start, strlen(text + start) + 1);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || (unsigned char)*c >= 0x7f)
            *c = '?';
    for (size_t n = strlen(text); n > 0 && text[n - 1] == ' '; n--)
        text[n - 1] = '\0';
}

/* OpenCL refuses a buffer that is too small, so ask into a large one and cut. */
static void keep_plain(const char *whole, cl_int status, char *text, size_t size) {
    size_t length = status == CL_SUCCESS ? strlen(whole) : 0;
    if (length > size - 1)
        length = size - 1;
    memcpy(text, whole, length);
    text[length] = '\0';
    make_plain(text);
}

void device_text(cl_device_id device, cl_device_info what, char *text, size_t size) {
    char whole[16384] = "";
    cl_int status = clGetDeviceInfo(device, what, sizeof whole - 1, whole, NULL);
    keep_plain(whole, status, text, size);
}

void platform_text(cl_platform_id platform, cl_platform_info what, char *text, size_t size) {
    char whole[16384] = "";
    cl_int status = clGetPlatformInfo(platform, what, sizeof whole - 1, whole, NULL);
    keep_plain(whole, status, text, size);
}

static int add_platform(device_list *list, cl_platform_id platform, int index, feeler_error *error) {
    cl_uint count = 0;
    cl_int status = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &count);
    /* A platform whose hardware is absent must not hide the others. */
    if (status != CL_SUCCESS || count == 0)
        return 0;

    cl_device_id *ids = calloc(count, sizeof *ids);
    device_entry *grown = realloc(list->entries, (list->count + count) * sizeof *grown);
    if (grown)
        list->entries = grown;
    if (!ids || !grown) {
        free(ids);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory while listing OpenCL devices");
    }
    status = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids, NULL);
    for (cl_uint i = 0; status == CL_SUCCESS && i < count; i++) {
        device_entry *entry = &list->entries[list->count++];
        *entry = (device_entry){.platform = platform, .id = ids[i], .platform_index = index};
        clGetDeviceInfo(ids[i], CL_DEVICE_TYPE, sizeof entry->type, &entry->type, NULL);
        platform_text(platform, CL_PLATFORM_NAME, entry->platform_name, sizeof entry->platform_name);
        device_text(ids[i], CL_DEVICE_NAME, entry->name, sizeof entry->name);
    }
    free(ids);
    return 0;
}

static size_t choose_default(const device_list *list) {
    for (size_t i = 0; i < list->count; i++)
        if (list->entries[i].type & CL_DEVICE_TYPE_CPU)
            return i;
    return 0;
}

int device_list_open(device_list *list, feeler_error *error) {
    cl_platform_id *platforms = NULL;
    cl_uint count = 0;
    *list = (device_list){0};

    cl_int status = clGetPlatformIDs(0, NULL, &count);
    if (status == PLATFORM_NOT_FOUND_KHR || (status == CL_SUCCESS && count == 0))
        return fail(error, FEELER_DEVICE,
                    "no OpenCL platform found (or too little memory to load its driver): install one (on Debian "
                    "'apt install pocl-opencl-icd' for the CPU), then try 'feeler doctor'");
    if (status != CL_SUCCESS)
        return fail_cl(error, "clGetPlatformIDs", status);

    platforms = calloc(count, sizeof *platforms);
    if (!platforms)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory while listing OpenCL platforms");
    status = clGetPlatformIDs(count, platforms, NULL);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clGetPlatformIDs", status);
        goto failed;
    }
    for (cl_uint i = 0; i < count; i++)
        if (add_platform(list, platforms[i], (int)i, error))
            goto failed;
    if (list->count == 0) {
        fail(error, FEELER_DEVICE,
             "%u OpenCL platform%s found, but no device (or too little memory to open it): install a driver that has "
             "one (on Debian "
             "'apt install pocl-opencl-icd' for the CPU), then try 'feeler doctor'",
             count, count == 1 ? "" : "s");
        goto failed;
    }
    list->chosen = choose_default(list);
    free(platforms);
    return 0;
failed:
    free(platforms);
    device_list_close(list);
    return -1;
}

void device_list_close(device_list *list) {
    free(list->entries);
    *list = (device_list){0};
}

static const char *type_name(cl_device_type type) {
    if (type & CL_DEVICE_TYPE_CPU)
        return "CPU";
    if (type & CL_DEVICE_TYPE_GPU)
        return "GPU";
    if (type & CL_DEVICE_TYPE_ACCELERATOR)
        return "accelerator";
    return "other";
}

static json_t *describe_device(const device_entry *entry, size_t index, bool chosen) {
    cl_uint units = 0, clock = 0;
    cl_ulong memory = 0;
    size_t group = 0;
    cl_device_fp_config doubles = 0;
    char version[256], driver[256];
    clGetDeviceInfo(entry->id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    clGetDeviceInfo(entry->id, CL_DEVICE_MAX_CLOCK_FREQUENCY, sizeof clock, &clock, NULL);
    clGetDeviceInfo(entry->id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory, NULL);
    clGetDeviceInfo(entry->id, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof group, &group, NULL);
    clGetDeviceInfo(entry->id, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, NULL);
    device_text(entry->id, CL_DEVICE_VERSION, version, sizeof version);
    device_text(entry->id, CL_DRIVER_VERSION, driver, sizeof driver);
    return json_pack("{s:I, s:s, s:s, s:b, s:i, s:i, s:I, s:I, s:b, s:s, s:s}", "index", (json_int_t)index, "name",
                     entry->name, "type", type_name(entry->type), "default", (int)chosen, "compute_units", (int)units,
                     "clock_mhz", (int)clock, "memory_bytes", (json_int_t)memory, "max_work_group", (json_int_t)group,
                     "double", doubles != 0, "version", version, "driver", driver);
}

static json_t *describe_platform(cl_platform_id platform) {
    char name[256], vendor[256], version[256];
    platform_text(platform, CL_PLATFORM_NAME, name, sizeof name);
    platform_text(platform, CL_PLATFORM_VENDOR, vendor, sizeof vendor);
    platform_text(platform, CL_PLATFORM_VERSION, version, sizeof version);
    return json_pack("{s:s, s:s, s:s, s:[]}", "name", name, "vendor", vendor, "version", version, "devices");
}

char *feeler_devices_json(feeler_error *error) {
    device_list list;
    char *text = NULL;
    json_t *platform = NULL; /* borrowed from `platforms` */
    if (device_list_open(&list, error))
        return NULL;

    json_t *platforms = json_array();
    bool whole = platforms != NULL;
    for (size_t i = 0; whole && i < list.count; i++) {
        const device_entry *entry = &list.entries[i];
        if (i == 0 || entry->platform != list.entries[i - 1].platform) {
            platform = describe_platform(entry->platform);
            whole = json_array_append_new(platforms, platform) == 0;
        }
        json_t *device = describe_device(entry, i, i == list.chosen);
        if (!whole)
            json_decref(device);
        else
            whole = json_array_append_new(json_object_get(platform, "devices"), device) == 0;
    }
    json_t *root = whole ? json_pack("{s:O}", "platforms", platforms) : NULL;
    if (root)
        text = json_dumps(root, JSON_INDENT(2));
    if (!text)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory while describing OpenCL devices");
    json_decref(root);
    json_decref(platforms);
    device_list_close(&list);
    return text;
}
