/* read_scene.c - a whole scene from nodes: the file, what it includes, and then materials before the objects that name
 * them. */
#define _XOPEN_SOURCE 700 /* realpath */

#include "schema.h"
#include "vec.h"
#include "yaml_nodes.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_PIXELS = 1 << 28, MAX_SIDE = 65536, MAX_INCLUDE_DEPTH = 32 };

/* One file of the scene; the scene's own comes last, after all that it includes. */
typedef struct document {
    struct document *next;
    const struct document *includer;
    node_pool pool;
    const feeler_node *root;
    const char *name; /* as errors say it */
    char *identity;   /* its real path; NULL for a tree without a file */
    char *directory;
    bool ready; /* everything that it includes has been read */
    const feeler_node *nodes[SCENE_SLOTS];
} document;

typedef struct loader {
    reader reader;
    document *documents;
    document **end;
} loader;

static void free_documents(document *documents) {
    while (documents) {
        document *next = documents->next;
        node_pool_free(&documents->pool);
        free(documents->identity);
        free(documents->directory);
        free(documents);
        documents = next;
    }
}

/* The part of a path up to its last slash, with it. */
static char *folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return strndup(path, slash ? (size_t)(slash - path) + 1 : 0);
}

/* ---- includes ---- */

static int read_document(loader *loader, document *document);

static int fail_cycle(const loader *loader, const feeler_node *node, const document *from, const document *again) {
    char chain[400] = "";
    for (const document *at = from; at; at = at == again ? NULL : at->includer) {
        char longer[sizeof chain];
        int length = snprintf(longer, sizeof longer, "%s%s%s", at->name, *chain ? " includes " : "", chain);
        if (length >= (int)sizeof longer)
            break;
        strcpy(chain, longer);
    }
    return fail_node(&loader->reader, node, "files include each other: %s includes %s", chain, again->name);
}

static const document *find_document(const loader *loader, const char *identity) {
    const document *at = loader->documents;
    while (at && !(at->identity && strcmp(at->identity, identity) == 0))
        at = at->next;
    return at;
}

static int fail_open(const loader *loader, const feeler_node *node, const char *path) {
    char here[NODE_PATH_SIZE];
    return fail_at(loader->reader.error, FEELER_IO, node_place(node, here),
                   "the included file '%s' cannot be opened: %s", path, strerror(errno));
}

/* The document of a file, put into the list; its root is still to be read. Takes `identity`. */
static document *add_document(loader *loader, const char *path, char *identity, const document *includer) {
    document *made = calloc(1, sizeof *made);
    if (!made) {
        free(identity);
        fail_memory(&loader->reader);
        return NULL;
    }
    made->identity = identity;
    made->includer = includer;
    made->directory = folder_of(path);
    made->name = scene_source(loader->reader.scene, path, loader->reader.error);
    *loader->end = made;
    loader->end = &made->next;
    if (!made->directory)
        fail_memory(&loader->reader);
    return made->directory && made->name ? made : NULL;
}

static int read_include(loader *loader, const document *from, const feeler_node *node) {
    const char *name = "";
    reader reader = loader->reader;
    reader.directory = from->directory;
    if (read_text(&reader, node, &name) != 0)
        return -1;
    char *path = resolve_path(&reader, name);
    if (!path)
        return fail_memory(&reader);
    int status = 0;
    char *identity = realpath(path, NULL);
    const document *known = identity ? find_document(loader, identity) : NULL;
    if (!identity) {
        status = fail_open(loader, node_value(node), path);
    } else if (known) { /* twice by different ways is once */
        status = known->ready ? 0 : fail_cycle(loader, node_value(node), from, known);
        free(identity);
    } else {
        document *made = add_document(loader, path, identity, from);
        status = made ? read_document(loader, made) : -1;
    }
    free(path);
    return status;
}

static int read_includes(loader *loader, document *from) {
    const feeler_node *list = from->nodes[SCENE_INCLUDE];
    if (!list)
        return 0;
    int depth = 0;
    for (const document *at = from; at; at = at->includer)
        depth++;
    list = node_value(list);
    if (list->kind != NODE_LIST)
        return fail_node(&loader->reader, list, "expected a list of files, not %s", node_kind_name(list));
    if (depth > MAX_INCLUDE_DEPTH)
        return fail_node(&loader->reader, list, "included more than %d files deep", MAX_INCLUDE_DEPTH);
    for (const feeler_node *child = list->children.first; child; child = child->next)
        if (read_include(loader, from, child) != 0)
            return -1;
    return 0;
}

/* Clearer than calling a key unknown that the scene's own file may hold. */
static int check_included(const loader *loader, const feeler_node *root) {
    if (root->kind != NODE_MAP)
        return 0;
    for (const feeler_node *child = root->children.first; child; child = child->next)
        if (schema_has(scene_keys, child->key) && !schema_has(included_keys, child->key))
            return fail_key(&loader->reader, child, "'%s' cannot stand in an included file, only in the scene's own",
                            child->key);
    return 0;
}

/* Reads a document's text, unless it has its root already, its top keys and all that it includes. */
static int read_document(loader *loader, document *document) {
    reader *reader = &loader->reader;
    if (!document->root)
        document->root = yaml_read_file(document->identity, document->name, &document->pool, reader->error);
    if (!document->root || (document->includer && check_included(loader, document->root) != 0))
        return -1;
    const schema_key *keys = document->includer ? included_keys : scene_keys;
    if (schema_read(reader, document->root, keys, reader->scene, document->nodes) != 0 ||
        read_includes(loader, document) != 0)
        return -1;
    document->ready = true;
    return 0;
}

/* ---- parts ---- */

static int read_size(const reader *reader, const feeler_node *node) {
    double size[2];
    node = node_value(node);
    if (read_numbers(reader, node, 2, size) != 0)
        return -1;
    for (size_t i = 0; i < 2; i++)
        if (!(size[i] >= 1 && size[i] <= MAX_SIDE && size[i] == (int)size[i]))
            return fail_item(reader, node, i, "the image's %s must be a whole number of pixels from 1 to %d, not %.9g",
                             i == 0 ? "width" : "height", MAX_SIDE, size[i]);
    if (size[0] * size[1] > MAX_PIXELS)
        return fail_node(reader, node, "%.0f x %.0f is more than %d pixels", size[0], size[1], MAX_PIXELS);
    reader->scene->width = (int)size[0];
    reader->scene->height = (int)size[1];
    return 0;
}

static int read_image(const reader *reader, const feeler_node *node) {
    const feeler_node *nodes[IMAGE_SLOTS] = {NULL};
    if (schema_read(reader, node, image_keys, reader->scene, nodes) != 0)
        return -1;
    return nodes[IMAGE_SIZE] ? read_size(reader, nodes[IMAGE_SIZE]) : 0;
}

/* The last of the map's `first` and `second`, or NULL: where a mistake of the two together is shown. */
static const feeler_node *last_of(const feeler_node *map, const char *first, const char *second) {
    const feeler_node *found = NULL;
    for (const feeler_node *child = node_value(map)->children.first; child; child = child->next)
        if (strcmp(child->key, first) == 0 || strcmp(child->key, second) == 0)
            found = child;
    return found;
}

static int read_camera(const reader *reader, const feeler_node *node) {
    scene_camera *camera = &reader->scene->camera;
    if (keep_place(reader, node, &camera->place) != 0 || schema_read(reader, node, camera_keys, camera, NULL) != 0)
        return -1;
    vec3 view = vec_subtract(camera->look_at, camera->eye);
    const feeler_node *up = last_of(node, "up", "up"), *places = last_of(node, "look_at", "eye");
    /* Nothing is wrong with the defaults, so that one of the keys is there. What is left is for scene_validate. */
    if (places && vec_extent(view) == 0)
        return fail_node(reader, node_value(places), "the camera's 'look_at' is its 'eye': it looks nowhere");
    const feeler_node *culprit = up ? up : places;
    vec3 upwards = camera->up;
    if (culprit && vec_normalize(&view) && vec_normalize(&upwards) && vec_parallel(view, upwards))
        return fail_node(reader, node_value(culprit), "the camera's 'up' is parallel to its view");
    return 0;
}

static int read_materials(reader *reader, const feeler_node *node) {
    node = node_value(node);
    if (node->kind != NODE_MAP)
        return fail_node(reader, node, "expected a map from names to materials, not %s", node_kind_name(node));
    for (const feeler_node *child = node->children.first; child; child = child->next) {
        if (!child->key[0])
            return fail_key(reader, child, "the material has no name");
        if (read_material(reader, child, child->key) != 0)
            return -1;
    }
    return 0;
}

static int read_list(reader *reader, const feeler_node *node, const char *of,
                     int (*read)(struct reader *, const feeler_node *)) {
    node = node_value(node);
    if (node->kind != NODE_LIST)
        return fail_node(reader, node, "expected a list of %s, not %s", of, node_kind_name(node));
    for (const feeler_node *child = node->children.first; child; child = child->next)
        if (read(reader, child) != 0)
            return -1;
    return 0;
}

/* All that one object means has its number: a mesh file may mean several, and so may an instance. */
static int read_numbered_object(reader *reader, const feeler_node *node) {
    size_t first = reader->scene->object_count;
    if (read_object(reader, node) != 0)
        return -1;
    for (size_t i = first; i < reader->scene->object_count; i++)
        reader->scene->objects[i].number = reader->object_count;
    reader->object_count++;
    return 0;
}

static int read_parts(loader *loader) {
    reader *reader = &loader->reader;
    for (const document *at = loader->documents; at; at = at->next)
        if (at->nodes[SCENE_MATERIALS] && read_materials(reader, at->nodes[SCENE_MATERIALS]) != 0)
            return -1;
    for (const document *at = loader->documents; at; at = at->next)
        if (at->nodes[SCENE_GROUPS] && declare_groups(reader, at->nodes[SCENE_GROUPS], at->directory) != 0)
            return -1;
    for (const document *at = loader->documents; at; at = at->next) {
        const feeler_node *const *nodes = at->nodes;
        reader->directory = at->directory;
        if ((nodes[SCENE_CAMERA] && read_camera(reader, nodes[SCENE_CAMERA]) != 0) ||
            (nodes[SCENE_IMAGE] && read_image(reader, nodes[SCENE_IMAGE]) != 0) ||
            (nodes[SCENE_LIGHTS] && read_list(reader, nodes[SCENE_LIGHTS], "lights", read_light) != 0) ||
            (nodes[SCENE_OBJECTS] && read_list(reader, nodes[SCENE_OBJECTS], "objects", read_numbered_object) != 0))
            return -1;
    }
    return read_groups(reader);
}

/* ---- the whole ---- */

static int start(loader *loader, feeler_error *error) {
    *loader = (struct loader){.reader = {.error = error, .directory = "", .default_material = -1}};
    loader->end = &loader->documents;
    loader->reader.scene = scene_new(error);
    return loader->reader.scene ? 0 : -1;
}

static feeler_scene *finish(loader *loader, int status) {
    feeler_scene *scene = loader->reader.scene;
    free_documents(loader->documents);
    name_table_free(&loader->reader.materials);
    free_groups(&loader->reader);
    if (status == 0)
        return scene;
    feeler_scene_free(scene);
    return NULL;
}

feeler_scene *scene_read_yaml(const char *path, feeler_error *error) {
    loader loader;
    if (start(&loader, error) != 0)
        return NULL;
    char *identity = realpath(path, NULL);
    int status = 0;
    if (!identity)
        status = fail_at(error, FEELER_IO, (place){path, 0, 0}, "cannot be opened: %s", strerror(errno));
    document *document = status == 0 ? add_document(&loader, path, identity, NULL) : NULL;
    if (!document || read_document(&loader, document) != 0 || read_parts(&loader) != 0)
        status = -1;
    return finish(&loader, status);
}

/* The directory with a slash at its end, or "". */
static char *with_slash(const char *directory) {
    size_t length = directory ? strlen(directory) : 0;
    char *path = malloc(length + 2);
    if (path)
        snprintf(path, length + 2, "%s%s", directory ? directory : "",
                 length > 0 && directory[length - 1] != '/' ? "/" : "");
    return path;
}

feeler_scene *feeler_scene_from_node(const feeler_node *node, const char *directory, feeler_error *error) {
    loader loader;
    if (!node) {
        fail(error, FEELER_BAD_USAGE, "no scene: the node is NULL");
        return NULL;
    }
    if (start(&loader, error) != 0)
        return NULL;
    document *document = add_document(&loader, "scene", NULL, NULL);
    int status = document ? 0 : -1;
    if (document) {
        free(document->directory);
        document->root = node;
        document->directory = with_slash(directory);
        loader.reader.scene->name = strdup("scene");
        if (!document->directory || !loader.reader.scene->name)
            status = fail_memory(&loader.reader);
    }
    if (status == 0 && (read_document(&loader, document) != 0 || read_parts(&loader) != 0 ||
                        scene_validate(loader.reader.scene, error) != 0))
        status = -1;
    return finish(&loader, status);
}
