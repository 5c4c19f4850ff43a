/* read_groups.c - groups, each read when the first instance asks for it, and what an instance of them means.
 *
 * An instance of a group that holds instances becomes several: one of the group's own objects, and one for each of those
 * instances with the product of both transforms. So there are two levels, whatever the scene nests.
 */
#include "schema.h"
#include "transform.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_NESTED = 64, MOST_INSTANCES = 1 << 24 };

enum { GROUP_UNREAD, GROUP_BEING_READ, GROUP_READ };

typedef struct group_entry {
    const feeler_node *node;
    const char *name, *directory;
    int state;
    int group;               /* of the scene: its objects that are no instances */
    scene_object *instances; /* owned; the others */
    size_t instance_count;
} group_entry;

int declare_groups(reader *reader, const feeler_node *node, const char *directory) {
    node = node_value(node);
    if (node->kind != NODE_MAP)
        return fail_node(reader, node, "expected a map from names to lists of objects, not %s", node_kind_name(node));
    for (const feeler_node *child = node->children.first; child; child = child->next) {
        if (!child->key[0])
            return fail_key(reader, child, "the group has no name");
        int status = name_add(&reader->groups, child->key, (int)reader->entry_count);
        if (status != 0)
            return status > 0 ? fail_key(reader, child, "the group '%.60s' is given twice", child->key)
                              : fail_memory(reader);
        group_entry *entries =
            grow(reader->entries, reader->entry_count, &reader->entry_capacity, sizeof *entries, reader->error);
        if (!entries)
            return -1;
        reader->entries = entries;
        entries[reader->entry_count++] = (group_entry){.node = child, .name = child->key, .directory = directory};
    }
    return 0;
}

/* Moves the scene's objects from `first` on into the group and, if they are instances, into the entry. */
static int take_objects(reader *reader, group_entry *entry, size_t first) {
    feeler_scene *scene = reader->scene;
    size_t count = scene->object_count - first;
    scene_object *objects = malloc(count * sizeof *objects), *instances = malloc(count * sizeof *instances);
    scene_group *group = objects && instances ? scene_add_group(scene, reader->error) : NULL;
    if (!group) {
        free(objects);
        free(instances);
        return fail_memory(reader);
    }
    entry->group = (int)scene->group_count - 1;
    entry->instances = instances;
    group->objects = objects;
    for (size_t i = first; i < scene->object_count; i++) {
        if (scene->objects[i].shape == SHAPE_INSTANCE)
            instances[entry->instance_count++] = scene->objects[i];
        else
            objects[group->object_count++] = scene->objects[i];
    }
    scene->object_count = first;
    return 0;
}

static int read_objects_of(reader *reader, size_t index) {
    const feeler_node *list = node_value(reader->entries[index].node);
    size_t first = reader->scene->object_count;
    if (list->kind != NODE_LIST)
        return fail_node(reader, list, "expected a list of objects, not %s", node_kind_name(list));
    for (const feeler_node *child = list->children.first; child; child = child->next)
        if (read_object(reader, child) != 0)
            return -1;
    if (reader->scene->object_count == first)
        return fail_node(reader, list, "the group '%.60s' is empty", reader->entries[index].name);
    for (size_t i = first; i < reader->scene->object_count; i++)
        if (reader->scene->objects[i].shape == SHAPE_PLANE)
            return fail_at(reader->error, FEELER_BAD_INPUT, reader->scene->objects[i].place,
                           "a plane has no end and cannot be in a group; a large disc or polygon can");
    return take_objects(reader, &reader->entries[index], first);
}

static int read_group(reader *reader, size_t index) {
    const char *directory = reader->directory;
    reader->entries[index].state = GROUP_BEING_READ;
    reader->directory = reader->entries[index].directory;
    reader->depth++;
    int status = read_objects_of(reader, index);
    reader->depth--;
    reader->directory = directory;
    reader->entries[index].state = GROUP_READ;
    return status;
}

int read_groups(reader *reader) {
    for (size_t i = 0; i < reader->entry_count; i++)
        if (reader->entries[i].state == GROUP_UNREAD && read_group(reader, i) != 0)
            return -1;
    return 0;
}

static int fail_unknown_group(const reader *reader, const feeler_node *node, const char *name) {
    char text[SHOWN_SIZE], hint[SUGGESTION_SIZE];
    suggestion nearest = suggest_for(name);
    for (size_t i = 0; i < reader->entry_count; i++)
        suggest_candidate(&nearest, reader->entries[i].name);
    return fail_node(reader, node_value(node), "unknown group '%s'%s", shown(name, text), suggest_text(&nearest, hint));
}

/* The entry that the key names, read; -1 on failure. */
static int find_group(reader *reader, const feeler_node *node) {
    const char *name = "";
    char text[SHOWN_SIZE];
    if (read_text(reader, node, &name) != 0)
        return -1;
    int index = name_find(&reader->groups, name);
    if (index < 0)
        return fail_unknown_group(reader, node, name);
    int state = reader->entries[index].state;
    if (state == GROUP_BEING_READ)
        return fail_node(reader, node_value(node), "the group '%s' holds itself", shown(name, text));
    if (state == GROUP_UNREAD && reader->depth >= MOST_NESTED)
        return fail_node(reader, node_value(node), "groups are nested more than %d deep", MOST_NESTED);
    return state == GROUP_UNREAD && read_group(reader, (size_t)index) != 0 ? -1 : index;
}

static int add_instance(reader *reader, int group, const matrix *matrix, int material, place place) {
    scene_object *object = scene_add_object(reader->scene, reader->error);
    if (!object)
        return -1;
    object->shape = SHAPE_INSTANCE;
    object->material = material;
    object->place = place;
    object->instance.group = group;
    object->instance.matrix = *matrix;
    return 0;
}

int read_instance(reader *reader, const feeler_node *node, const matrix *m, int material, place place) {
    int index = find_group(reader, node);
    if (index < 0)
        return -1;
    const group_entry *entry = &reader->entries[index];
    if (reader->scene->object_count + entry->instance_count >= MOST_INSTANCES)
        return fail_node(reader, node_value(node), "more than %d instances, with those in groups", MOST_INSTANCES);
    if (reader->scene->groups[entry->group].object_count > 0 &&
        add_instance(reader, entry->group, m, material, place) != 0)
        return -1;
    for (size_t i = 0; i < entry->instance_count; i++) {
        const scene_object *inner = &entry->instances[i];
        matrix product = matrix_multiply(m, &inner->instance.matrix);
        if (add_instance(reader, inner->instance.group, &product, material >= 0 ? material : inner->material, place) !=
            0)
            return -1;
    }
    return 0;
}

int make_instance(feeler_scene *scene, size_t index, const matrix *m, feeler_error *error) {
    scene_object *inner = malloc(sizeof *inner), *object = &scene->objects[index];
    scene_group *group = inner ? scene_add_group(scene, error) : NULL;
    if (!group) {
        free(inner);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    *inner = *object;
    *group = (scene_group){.objects = inner, .object_count = 1};
    *object = (scene_object){.shape = SHAPE_INSTANCE, .material = -1, .number = inner->number, .place = inner->place};
    object->instance.group = (int)scene->group_count - 1;
    object->instance.matrix = *m;
    return 0;
}

void free_groups(reader *reader) {
    for (size_t i = 0; i < reader->entry_count; i++)
        free(reader->entries[i].instances);
    free(reader->entries);
    name_table_free(&reader->groups);
}
