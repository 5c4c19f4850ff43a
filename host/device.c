/* device.c - opens an OpenCL device, or takes a caller's. */
#include "device.h"

#include "device_list.h"
#include "scene.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool contains(const char *text, const char *part) {
    for (; *text; text++) {
        size_t n = 0;
        while (part[n] && tolower((unsigned char)text[n]) == tolower((unsigned char)part[n]))
            n++;
        if (!part[n])
            return true;
    }
    return false;
}

static bool matches(const device_entry *entry, const char *part) {
    return contains(entry->name, part) || contains(entry->platform_name, part);
}

/* "0 'cpu' (PoCL), 1 'gpu' (X)": those that match `part`, or all where it is NULL. */
static void list_names(const device_list *list, const char *part, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < list->count && used < size; i++) {
        const device_entry *entry = &list->entries[i];
        if (part && !matches(entry, part))
            continue;
        int n = snprintf(text + used, size - used, "%s%zu '%s' (%s)", used ? ", " : "", i, entry->name,
                         entry->platform_name);
        if (n < 0)
            return;
        used += (size_t)n;
    }
}

static int select_by_number(const device_list *list, const char *select, size_t *chosen, feeler_error *error) {
    char names[1024];
    errno = 0;
    unsigned long number = strtoul(select, NULL, 10);
    if (errno == 0 && number < list->count) {
        *chosen = number;
        return 0;
    }
    list_names(list, NULL, names, sizeof names);
    return fail(error, FEELER_DEVICE, "no OpenCL device has the number %.40s; there %s %s", select,
                list->count == 1 ? "is" : "are", names);
}

static int select_device(const device_list *list, const char *select, size_t *chosen, feeler_error *error) {
    char names[1024];
    size_t found = 0;
    *chosen = list->chosen;
    if (!select || !*select)
        return 0;
    if (strspn(select, "0123456789") == strlen(select))
        return select_by_number(list, select, chosen, error);

    for (size_t i = 0; i < list->count; i++)
        if (matches(&list->entries[i], select) && found++ == 0)
            *chosen = i;
    if (found == 1)
        return 0;
    list_names(list, found ? select : NULL, names, sizeof names);
    if (found == 0)
        return fail(error, FEELER_DEVICE, "no OpenCL device or platform has '%.80s' in its name; there %s %s", select,
                    list->count == 1 ? "is" : "are", names);
    return fail(error, FEELER_DEVICE, "'%.80s' fits %zu OpenCL devices: %s; choose one by its number", select, found,
                names);
}

/* The properties that rendering asks for. */
static int describe(feeler_device *device, feeler_error *error) {
    cl_device_type type = 0;
    cl_device_fp_config doubles = 0;
    cl_bool available = CL_FALSE, compiler = CL_FALSE;
    device_text(device->id, CL_DEVICE_NAME, device->name, sizeof device->name);

    cl_int status = clGetDeviceInfo(device->id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    if (status == CL_SUCCESS)
        status = clGetDeviceInfo(device->id, CL_DEVICE_AVAILABLE, sizeof available, &available, NULL);
    if (status == CL_SUCCESS)
        status = clGetDeviceInfo(device->id, CL_DEVICE_COMPILER_AVAILABLE, sizeof compiler, &compiler, NULL);
    if (status == CL_SUCCESS)
        status = clGetDeviceInfo(device->id, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof device->max_work_group,
                                 &device->max_work_group, NULL);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clGetDeviceInfo", status);
    if (!available)
        return fail(error, FEELER_DEVICE, "the OpenCL device '%s' is not available now", device->name);
    if (!compiler)
        return fail(error, FEELER_DEVICE, "the OpenCL device '%s' has no compiler; choose another", device->name);

    /* A device without doubles may answer with 0 or with an error. */
    if (clGetDeviceInfo(device->id, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, NULL) == CL_SUCCESS)
        device->has_double = doubles != 0;
    device->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    return 0;
}

static feeler_device *new_device(feeler_error *error) {
    feeler_device *device = calloc(1, sizeof *device);
    if (!device)
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory while opening a device");
    return device;
}

feeler_device *feeler_device_open(const char *select, feeler_error *error) {
    device_list list;
    size_t chosen;
    cl_int status;
    feeler_device *device = NULL;
    if (device_list_open(&list, error))
        return NULL;
    if (select_device(&list, select, &chosen, error))
        goto failed;
    device = new_device(error);
    if (!device)
        goto failed;

    device->id = list.entries[chosen].id;
    if (describe(device, error))
        goto failed;
    cl_context_properties properties[] = {CL_CONTEXT_PLATFORM, (cl_context_properties)list.entries[chosen].platform, 0};
    device->context = clCreateContext(properties, 1, &device->id, NULL, NULL, &status);
    if (!device->context) {
        fail_cl(error, "clCreateContext", status);
        goto failed;
    }
    /* Out of order where that is known: a launch begins while the last groups of the one before still run. */
    cl_command_queue_properties can = 0, wanted = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE;
    (void)clGetDeviceInfo(device->id, CL_DEVICE_QUEUE_PROPERTIES, sizeof can, &can, NULL);
    device->queue =
        clCreateCommandQueue(device->context, device->id, CL_QUEUE_PROFILING_ENABLE | (can & wanted), &status);
    if (!device->queue) {
        fail_cl(error, "clCreateCommandQueue", status);
        goto failed;
    }
    device_list_close(&list);
    return device;
failed:
    device_list_close(&list);
    feeler_device_close(device);
    return NULL;
}

/* A queue of another context or device would fail later with a status that explains nothing. */
static int check_belongs(cl_context context, cl_device_id id, cl_command_queue queue, feeler_error *error) {
    cl_context queue_context = NULL;
    cl_device_id queue_device = NULL;
    cl_int status = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof queue_context, &queue_context, NULL);
    if (status == CL_SUCCESS)
        status = clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof queue_device, &queue_device, NULL);
    if (status != CL_SUCCESS)
        return fail_cl(error, "clGetCommandQueueInfo", status);
    if (queue_context != context)
        return fail(error, FEELER_BAD_USAGE, "the queue belongs to another context");
    if (queue_device != id)
        return fail(error, FEELER_BAD_USAGE, "the queue belongs to another device");
    return 0;
}

feeler_device *feeler_device_wrap(intptr_t context, intptr_t device_id, intptr_t queue, feeler_error *error) {
    if (!context || !device_id || !queue) {
        fail(error, FEELER_BAD_USAGE, "context, device and queue must not be null");
        return NULL;
    }
    if (check_belongs((cl_context)context, (cl_device_id)device_id, (cl_command_queue)queue, error))
        return NULL;
    feeler_device *device = new_device(error);
    if (!device)
        return NULL;

    device->id = (cl_device_id)device_id;
    if (describe(device, error))
        goto failed;
    cl_int status = clRetainContext((cl_context)context);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clRetainContext", status);
        goto failed;
    }
    device->context = (cl_context)context;
    status = clRetainCommandQueue((cl_command_queue)queue);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clRetainCommandQueue", status);
        goto failed;
    }
    device->queue = (cl_command_queue)queue;
    return device;
failed:
    feeler_device_close(device);
    return NULL;
}

void feeler_device_close(feeler_device *device) {
    if (!device)
        return;
    /* Nothing sensible can be done when releasing fails. */
    for (int i = 0; i < MOST_BUILT; i++) {
        if (device->built[i].program)
            (void)clReleaseProgram(device->built[i].program);
        free(device->built[i].options);
    }
    if (device->queue)
        (void)clReleaseCommandQueue(device->queue);
    if (device->context)
        (void)clReleaseContext(device->context);
    free(device);
}

const char *feeler_device_name(const feeler_device *device) {
    return device->name;
}
