/* device_list.h - the OpenCL devices of this machine, in the order in which they are numbered. */
#ifndef FEELER_DEVICE_LIST_H
#define FEELER_DEVICE_LIST_H

#include "device.h"

typedef struct device_entry {
    cl_platform_id platform;
    cl_device_id id;
    cl_device_type type;
    int platform_index;
    char platform_name[256];
    char name[256];
} device_entry;

typedef struct device_list {
    device_entry *entries;
    size_t count;
    size_t chosen; /* the default: the first CPU device, else the first */
} device_list;

/* Fills an empty list with at least one device; -1 and nothing allocated where there is none. */
int device_list_open(device_list *list, feeler_error *error);
void device_list_close(device_list *list);

/* A text property of a device or platform, plain ASCII without outer spaces; "" where the driver does not tell. */
void device_text(cl_device_id device, cl_device_info what, char *text, size_t size);
void platform_text(cl_platform_id platform, cl_platform_info what, char *text, size_t size);

#endif
