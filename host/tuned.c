/* tuned.c - the user's file of work groups: where it is, what it says, how it is kept. */
#include "tuned.h"

#include "replacement.h"
#include "schema.h"
#include "yaml_nodes.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- where ---- */

static char *join(const char *folder, const char *rest) {
    size_t size = strlen(folder) + strlen(rest) + 1;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s%s", folder, rest);
    return path;
}

char *feeler_tuned_path(void) {
    const char *chosen = getenv("FEELER_TUNED"), *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    if (chosen)
        return *chosen ? strdup(chosen) : NULL;
    if (config && *config == '/') /* by the specification a relative one does not count */
        return join(config, "/feeler/work-groups.yaml");
    return home && *home ? join(home, "/.config/feeler/work-groups.yaml") : NULL;
}

/* ---- reading ---- */

/* Kernels are told apart by their build options: they have all that a kernel's code and stacks depend on. */
typedef struct entry {
    const char *device, *options; /* borrowed */
    int group[2];
} entry;

typedef struct entries {
    node_pool pool; /* holds the texts */
    entry *list;    /* room for one more than there are */
    size_t count;
} entries;

enum { ENTRY_DEVICE, ENTRY_OPTIONS, ENTRY_WORK_GROUP, ENTRY_SLOTS };
static const schema_key file_keys[] = {{.name = "work_groups", .type = KEY_NODE, .flags = KEY_REQUIRED}, {0}};
static const schema_key entry_keys[] = {
    {.name = "device", .type = KEY_NODE, .offset = ENTRY_DEVICE, .flags = KEY_REQUIRED},
    {.name = "options", .type = KEY_NODE, .offset = ENTRY_OPTIONS, .flags = KEY_REQUIRED},
    {.name = "work_group", .type = KEY_NODE, .offset = ENTRY_WORK_GROUP, .flags = KEY_REQUIRED},
    {0},
};

static int read_entry(const reader *reader, const feeler_node *node, entry *e) {
    const feeler_node *nodes[ENTRY_SLOTS] = {0};
    if (schema_read(reader, node, entry_keys, e, nodes) < 0 || read_text(reader, nodes[ENTRY_DEVICE], &e->device) < 0 ||
        read_text(reader, nodes[ENTRY_OPTIONS], &e->options) < 0)
        return -1;
    const feeler_node *group = node_value(nodes[ENTRY_WORK_GROUP]);
    if (group->kind != NODE_LIST || group->children.count != 2)
        return fail_node(reader, group, "expected a list of 2 numbers");
    const feeler_node *x = group->children.first;
    return read_integer(reader, x, 1, 65536, "a side of a work group", &e->group[0]) < 0 ||
                   read_integer(reader, x->next, 1, 65536, "a side of a work group", &e->group[1]) < 0
               ? -1
               : 0;
}

static void entries_free(entries *all) {
    free(all->list);
    node_pool_free(&all->pool);
}

static int read_entries(const char *path, entries *all, feeler_error *error) {
    const reader reader = {.error = error};
    const feeler_node *list = NULL, *root = yaml_read_file(path, path, &all->pool, error);
    if (!root || schema_read(&reader, root, file_keys, NULL, &list) < 0)
        return -1;
    list = node_value(list);
    if (list->kind != NODE_LIST)
        return fail_node(&reader, list, "expected a list");
    entry *room = realloc(all->list, (list->children.count + 1) * sizeof *room);
    if (!room)
        return fail_memory(&reader);
    all->list = room;
    for (const feeler_node *node = list->children.first; node; node = node->next)
        if (read_entry(&reader, node, &all->list[all->count++]) < 0)
            return -1;
    return 0;
}

/* No file, no entries. On failure nothing is left to be freed. */
static int entries_read(const char *path, entries *all, feeler_error *error) {
    *all = (entries){.list = malloc(sizeof(entry))};
    if (!all->list)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    if (!path || (access(path, F_OK) && (errno == ENOENT || errno == ENOTDIR)))
        return 0;
    if (read_entries(path, all, error) == 0)
        return 0;
    entries_free(all);
    return -1;
}

int feeler_tuned_check(feeler_error *error) {
    entries all;
    char *path = feeler_tuned_path();
    int status = entries_read(path, &all, error);
    if (status == 0)
        entries_free(&all);
    free(path);
    return status;
}

/* ---- looking up ---- */

bool tuned_find(const char *device, const char *options, int group[2]) {
    char *path = feeler_tuned_path();
    entries all;
    bool found = false;
    if (entries_read(path, &all, NULL) == 0) {
        for (size_t i = 0; i < all.count && !found; i++) {
            const entry *e = &all.list[i];
            found = strcmp(e->device, device) == 0 && strcmp(e->options, options) == 0;
            if (found)
                memcpy(group, e->group, sizeof e->group);
        }
        entries_free(&all);
    }
    free(path);
    return found;
}

json_t *tuned_json(const char *options) {
    char *path = feeler_tuned_path();
    entries all;
    json_t *json = json_object(), *groups = json_object();
    if (entries_read(path, &all, NULL) == 0) {
        for (size_t i = 0; i < all.count; i++) {
            const entry *e = &all.list[i];
            if (strcmp(e->options, options) == 0)
                json_object_set_new(groups, e->device, json_pack("[i, i]", e->group[0], e->group[1]));
        }
        entries_free(&all);
    }
    if (json_object_size(groups)) {
        json_object_set_new(json, "file", json_string(path));
        json_object_set(json, "work_groups", groups);
    }
    json_decref(groups);
    free(path);
    return json;
}

/* ---- keeping ---- */

static int make_folders(const char *path, feeler_error *error) {
    char *folder = strdup(path);
    int status = folder ? 0 : fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (char *slash = folder; status == 0 && (slash = strchr(slash + 1, '/'));) {
        *slash = '\0';
        if (mkdir(folder, 0700) && errno != EEXIST)
            status = fail(error, FEELER_IO, "%s: cannot make the folder '%s': %s", path, folder, strerror(errno));
        *slash = '/';
    }
    free(folder);
    return status;
}

static void write_text(FILE *file, const char *key, const char *text) {
    fprintf(file, "  %s: \"", key);
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c < 0x20 || c == '"' || c == '\\')
            fprintf(file, "\\x%02x", c);
        else
            fputc(c, file);
    }
    fputs("\"\n", file);
}

static int write_entries(const char *path, const entries *all, feeler_error *error) {
    replacement file;
    if (make_folders(path, error) < 0 || replacement_open(&file, path, error) < 0)
        return -1;
    FILE *stream = fopen(file.temporary, "w");
    if (stream) {
        fputs("# Kept by `feeler bench --save`: a render takes these work groups unless it is given one.\n"
              "work_groups:\n",
              stream);
        for (size_t i = 0; i < all->count; i++) {
            const entry *e = &all->list[i];
            fputs("-\n", stream);
            write_text(stream, "device", e->device);
            write_text(stream, "options", e->options);
            fprintf(stream, "  work_group: [%d, %d]\n", e->group[0], e->group[1]);
        }
    }
    bool whole = stream && !ferror(stream);
    if (stream && fclose(stream))
        whole = false;
    int status = whole ? 0 : fail(error, FEELER_IO, "%s: cannot write: %s", path, strerror(errno));
    return replacement_close(&file, status, error);
}

int feeler_tuned_keep(const char *stats_json, feeler_error *error) {
    char *path = feeler_tuned_path();
    json_t *stats = json_loads(stats_json, 0, NULL);
    entry kept;
    entries all;
    int status = 0;
    if (!stats || json_unpack(stats, "{s:s, s:s, s:[i,i]}", "device", &kept.device, "options", &kept.options,
                              "work_group", &kept.group[0], &kept.group[1]))
        status = fail(error, FEELER_BAD_USAGE, "these are not the statistics of a render");
    if (status == 0 && !path)
        status = fail(error, FEELER_BAD_USAGE,
                      "there is no file to keep work groups in: FEELER_TUNED is empty, or neither XDG_CONFIG_HOME nor "
                      "HOME is set");
    if (status == 0 && (status = entries_read(path, &all, error)) == 0) {
        size_t i = 0;
        while (i < all.count && (strcmp(all.list[i].device, kept.device) || strcmp(all.list[i].options, kept.options)))
            i++;
        all.list[i] = kept;
        all.count += i == all.count;
        status = write_entries(path, &all, error);
        entries_free(&all);
    }
    json_decref(stats);
    free(path);
    return status;
}
