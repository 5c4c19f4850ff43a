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

/* What a kernel is told apart by, and the work group that suits it. */
typedef struct entry {
    const char *device, *features; /* borrowed; features as their names with a space between */
    int level, lanes, group[2];
} entry;

typedef struct entries {
    node_pool pool; /* holds the texts */
    entry *list;    /* room for one more than there are */
    size_t count;
} entries;

enum { ENTRY_DEVICE, ENTRY_FEATURES, ENTRY_WORK_GROUP, ENTRY_SLOTS };
static const char no_features[] = "none"; /* an empty text would look like a mistake */
static const char *const levels[] = {"draft", "standard", "reference", NULL};
static const schema_key file_keys[] = {{.name = "work_groups", .type = KEY_NODE, .flags = KEY_REQUIRED}, {0}};
static const schema_key entry_keys[] = {
    {.name = "device", .type = KEY_NODE, .offset = ENTRY_DEVICE, .flags = KEY_REQUIRED},
    {.name = "level", .type = KEY_CHOICE, .offset = offsetof(entry, level), .flags = KEY_REQUIRED, .choices = levels},
    {.name = "lanes",
     .type = KEY_INTEGER,
     .offset = offsetof(entry, lanes),
     .low = 1,
     .high = 64,
     .flags = KEY_REQUIRED},
    {.name = "features", .type = KEY_NODE, .offset = ENTRY_FEATURES, .flags = KEY_REQUIRED},
    {.name = "work_group", .type = KEY_NODE, .offset = ENTRY_WORK_GROUP, .flags = KEY_REQUIRED},
    {0},
};

static int read_entry(const reader *reader, const feeler_node *node, entry *e) {
    const feeler_node *nodes[ENTRY_SLOTS] = {0};
    if (schema_read(reader, node, entry_keys, e, nodes) < 0 || read_text(reader, nodes[ENTRY_DEVICE], &e->device) < 0 ||
        read_text(reader, nodes[ENTRY_FEATURES], &e->features) < 0)
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

static bool same_kernel(const entry *a, const entry *b) {
    return a->level == b->level && a->lanes == b->lanes && strcmp(a->features, b->features) == 0;
}

static entry describe_kernel(const feeler_settings *s, needs n, char features[1024]) {
    features_text(n.features, features, 1024);
    if (!*features)
        strcpy(features, no_features);
    return (entry){.features = features, .level = s->level, .lanes = s->lanes};
}

bool tuned_find(const char *device, const feeler_settings *s, needs n, int group[2]) {
    char features[1024], *path = feeler_tuned_path();
    const entry wanted = describe_kernel(s, n, features);
    entries all;
    bool found = false;
    if (entries_read(path, &all, NULL) == 0) {
        for (size_t i = 0; i < all.count && !found; i++) {
            found = strcmp(all.list[i].device, device) == 0 && same_kernel(&all.list[i], &wanted);
            if (found)
                memcpy(group, all.list[i].group, sizeof all.list[i].group);
        }
        entries_free(&all);
    }
    free(path);
    return found;
}

json_t *tuned_json(const feeler_settings *s, needs n) {
    char features[1024], *path = feeler_tuned_path();
    const entry wanted = describe_kernel(s, n, features);
    entries all;
    json_t *json = json_object(), *groups = json_object();
    if (entries_read(path, &all, NULL) == 0) {
        for (size_t i = 0; i < all.count; i++)
            if (same_kernel(&all.list[i], &wanted))
                json_object_set_new(groups, all.list[i].device,
                                    json_pack("[i, i]", all.list[i].group[0], all.list[i].group[1]));
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
            fprintf(stream, "  level: %s\n  lanes: %d\n", levels[e->level], e->lanes);
            write_text(stream, "features", e->features);
            fprintf(stream, "  work_group: [%d, %d]\n", e->group[0], e->group[1]);
        }
    }
    bool whole = stream && !ferror(stream);
    if (stream && fclose(stream))
        whole = false;
    int status = whole ? 0 : fail(error, FEELER_IO, "%s: cannot write: %s", path, strerror(errno));
    return replacement_close(&file, status, error);
}

/* The words of a JSON list with a space between; false: it is no list of words, or there is no room. */
static bool join_words(const json_t *list, char *text, size_t size) {
    size_t i, used = 0;
    json_t *word;
    json_array_foreach(list, i, word) {
        if (!json_is_string(word) || used >= size)
            return false;
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? " " : "", json_string_value(word));
    }
    return json_is_array(list) && used < size;
}

/* What a render's statistics say of its device, kernel and work group; borrows from `stats` and `features`. */
static int read_stats(json_t *stats, char features[1024], entry *e, feeler_error *error) {
    const char *level = "";
    json_t *list = NULL;
    *e = (entry){.features = features};
    bool known =
        stats && json_unpack(stats, "{s:s, s:s, s:i, s:o, s:[i,i]}", "device", &e->device, "level", &level, "lanes",
                             &e->lanes, "features", &list, "work_group", &e->group[0], &e->group[1]) == 0;
    while (known && levels[e->level] && strcmp(levels[e->level], level) != 0)
        e->level++;
    if (!known || !levels[e->level] || !join_words(list, features, 1024))
        return fail(error, FEELER_BAD_USAGE, "these are not the statistics of a render");
    if (!*features)
        strcpy(features, no_features);
    return 0;
}

int feeler_tuned_keep(const char *stats_json, feeler_error *error) {
    char features[1024] = "", *path = feeler_tuned_path();
    json_t *stats = json_loads(stats_json, 0, NULL);
    entry kept;
    entries all;
    int status = read_stats(stats, features, &kept, error);
    if (status == 0 && !path)
        status = fail(error, FEELER_BAD_USAGE,
                      "there is no file to keep work groups in: FEELER_TUNED is empty, or neither XDG_CONFIG_HOME nor "
                      "HOME is set");
    if (status == 0 && (status = entries_read(path, &all, error)) == 0) {
        size_t i = 0;
        while (i < all.count && !(strcmp(all.list[i].device, kept.device) == 0 && same_kernel(&all.list[i], &kept)))
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
