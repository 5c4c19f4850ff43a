/* schema.h - the tables of keys that a scene may hold, and the reader that they drive.
 *
 * One row says a key's name, type, range and default; parsing, the defaults of scene_new and scene_validate all read it.
 * docs/scene-format.md documents every row.
 */
#ifndef FEELER_SCHEMA_H
#define FEELER_SCHEMA_H

#include "node.h"
#include "scene.h"

typedef enum key_type {
    KEY_NUMBER,    /* double */
    KEY_INTEGER,   /* int */
    KEY_BOOL,      /* bool */
    KEY_CHOICE,    /* int: the index among `choices` */
    KEY_POINT,     /* vec3 */
    KEY_DIRECTION, /* vec3 of any length but zero; scene_validate makes it 1 */
    KEY_COLOUR,    /* vec3, written as three numbers or one */
    KEY_NODE       /* anything: handed on as a node, in slot `offset` */
} key_type;

enum {
    KEY_REQUIRED = 1,
    KEY_ABOVE_LOW = 2,
    KEY_BELOW_HIGH = 4
}; /* the latter two: the range's end does not belong to it */

typedef struct schema_key {
    const char *name; /* NULL ends a table */
    key_type type;
    size_t offset;
    double low, high;   /* of each component */
    double standard[3]; /* the default; a number's is the first */
    unsigned flags;
    const char *const *choices;
} schema_key;

/* A table has at most 32 rows. */
#define MAX_COORDINATE 1e15
/* Of a radius or a cone's height: what is computed from it stays well within what a float can hold. */
#define MIN_LENGTH 1e-30

/* Slots of KEY_NODE rows. */
enum {
    SCENE_CAMERA,
    SCENE_IMAGE,
    SCENE_LIGHTS,
    SCENE_MATERIALS,
    SCENE_GROUPS,
    SCENE_OBJECTS,
    SCENE_INCLUDE,
    SCENE_SLOTS
};
enum { IMAGE_SIZE, IMAGE_SLOTS };
enum { LIGHT_POINT, LIGHT_DIRECTIONAL, LIGHT_COLOUR, LIGHT_SLOTS };
/* The shapes first, so that a slot below OBJECT_SHAPES is a shape. */
enum {
    OBJECT_SPHERE,
    OBJECT_PLANE,
    OBJECT_DISC,
    OBJECT_BOX,
    OBJECT_TRIANGLE,
    OBJECT_POLYGON,
    OBJECT_CYLINDER,
    OBJECT_CONE,
    OBJECT_MESH,
    OBJECT_INSTANCE,
    OBJECT_SHAPES,
    OBJECT_MATERIAL = OBJECT_SHAPES,
    OBJECT_TRANSFORM,
    OBJECT_SLOTS
};
enum { CORNERS, CORNERS_NORMALS, CORNERS_SLOTS };
enum { MESH_FILE, MESH_VERTICES, MESH_TRIANGLES, MESH_NORMALS, MESH_SMOOTH, MESH_SLOTS };
enum {
    TRANSFORM_TRANSLATE,
    TRANSFORM_ROTATE,
    TRANSFORM_ROTATE_X,
    TRANSFORM_ROTATE_Y,
    TRANSFORM_ROTATE_Z,
    TRANSFORM_SCALE,
    TRANSFORM_MATRIX,
    TRANSFORM_SLOTS
};

typedef struct rotation {
    vec3 axis;
    double angle; /* degrees */
} rotation;

/* A cylinder's radius goes to both radii when it has been read. */
extern const schema_key scene_keys[], included_keys[], camera_keys[], image_keys[], light_keys[], material_keys[],
    object_keys[], sphere_keys[], plane_keys[], disc_keys[], box_keys[], triangle_keys[], polygon_keys[],
    cylinder_keys[], cone_keys[], mesh_keys[], transform_keys[], rotation_keys[];
extern const schema_key light_colour_key;

/* Names of materials or groups, for look-up. */
typedef struct name_table {
    struct name_slot {
        const char *name;
        int index;
    } * slots;
    size_t count, capacity;
} name_table;

/* What reading a scene from nodes needs at hand. */
typedef struct reader {
    feeler_scene *scene;
    feeler_error *error;
    const char *directory; /* of the file being read, "" or with a slash at its end */
    name_table materials;
    int default_material; /* index, or -1 while there is none */
    name_table groups;
    struct group_entry *entries; /* by the index of the name */
    size_t entry_count, entry_capacity;
    int depth;        /* groups that are being read */
    int object_count; /* of the scene's lists that have been read */
} reader;

/* ---- schema.c: tables against nodes ---- */

/* Sets every row's target, but KEY_NODE's, to its default. */
void schema_set_defaults(const schema_key *keys, void *target);
/* Reads a map by its table into `target`; KEY_NODE values go to `nodes`, which has a slot for each and starts zeroed. */
int schema_read(const reader *reader, const feeler_node *node, const schema_key *keys, void *target,
                const feeler_node **nodes);
bool schema_has(const schema_key *keys, const char *name);
/* Reads the value of one key that schema_read handed on as a node. */
int schema_read_one(const reader *reader, const feeler_node *node, const schema_key *key, void *target);
/* Whether every number of `target` lies in its row's range and is finite; `what` begins the message. */
int schema_check(const schema_key *keys, const void *target, place place, const char *what, feeler_error *error);

/* ---- values.c: single values from nodes ---- */

/* Each refuses what is not wholly of its type, and numbers that are not finite. */
int read_number(const reader *reader, const feeler_node *node, double *value);
int read_integer(const reader *reader, const feeler_node *node, double low, double high, const char *name, int *value);
int read_bool(const reader *reader, const feeler_node *node, bool *value);
int read_text(const reader *reader, const feeler_node *node, const char **value);
int read_choice(const reader *reader, const feeler_node *node, const char *const *choices, int *value);
/* Exactly `count` numbers, from a list or an array. */
int read_numbers(const reader *reader, const feeler_node *node, size_t count, double *values);
int read_vector(const reader *reader, const feeler_node *node, vec3 *value);
int read_colour(const reader *reader, const feeler_node *node, vec3 *value);
/* A list of vectors, or an N x 3 array: newly allocated, also when N is 0. `what` names it in the plural. */
int read_vectors(const reader *reader, const feeler_node *node, vec3 **values, size_t *count);
/* At the node (or at its item, where the node is a list or array), or at its key. */
int fail_node(const reader *reader, const feeler_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
int fail_item(const reader *reader, const feeler_node *node, size_t item, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
int fail_key(const reader *reader, const feeler_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
int fail_memory(const reader *reader);
/* The place to keep with what is read from a node: outlives the tree. -1 when out of memory. */
int keep_place(const reader *reader, const feeler_node *node, place *kept);

/* ---- suggest.c ---- */

enum { SUGGESTION_SIZE = 160 };
/* " (did you mean 'x'?)" for the candidate nearest to `name`, else "". Feed candidates one by one, then ask. */
typedef struct suggestion {
    const char *name;
    const char *best;
    size_t distance;
} suggestion;
suggestion suggest_for(const char *name);
void suggest_candidate(suggestion *suggestion, const char *candidate);
const char *suggest_text(const suggestion *suggestion, char buffer[SUGGESTION_SIZE]);
/* A text for a message: at most some 40 characters, no control characters. */
enum { SHOWN_SIZE = 64 };
const char *shown(const char *text, char buffer[SHOWN_SIZE]);

/* ---- names.c ---- */

/* 0; 1 when the name is there already; -1 when out of memory. Keeps the pointer, not a copy. */
int name_add(name_table *table, const char *name, int index);
/* The index, or -1. */
int name_find(const name_table *table, const char *name);
void name_table_free(name_table *table);

/* ---- read_objects.c, read_mesh.c, read_transform.c, read_scene.c ---- */

/* Appends a material; its name (NULL for an inline one) must be new. */
int read_material(reader *reader, const feeler_node *node, const char *name);
/* The index of a matte grey, made when the first object without a material asks; -1 on failure. */
int read_default_material(reader *reader);
int read_light(reader *reader, const feeler_node *node);
/* Appends what an object of the scene means: one object, or those of a mesh file. */
int read_object(reader *reader, const feeler_node *node);
int read_mesh(reader *reader, const feeler_node *node, int material, place place);
int read_transform(const reader *reader, const feeler_node *node, matrix *matrix);
/* A file name of the scene, seen from the scene's folder; to be freed. NULL: out of memory. */
char *resolve_path(const reader *reader, const char *name);

/* ---- read_groups.c ---- */

/* Notes the names in a `groups` map; `directory` is that of its file and outlives the reader. */
int declare_groups(reader *reader, const feeler_node *node, const char *directory);
/* Reads the groups that no instance has asked for yet. */
int read_groups(reader *reader);
/* Appends the instances that an `instance` key means: one, and those in the group moved along. `material`: -1 for none. */
int read_instance(reader *reader, const feeler_node *node, const matrix *matrix, int material, place place);
/* Puts the scene's object at `index` into a group of its own, and an instance of it in its place. */
int make_instance(feeler_scene *scene, size_t index, const matrix *matrix, feeler_error *error);
void free_groups(reader *reader);

/* ---- scene.c ---- */

/* Makes room for one more of `count` items. Returns the items, moved or not, or NULL; then the old ones are intact. */
void *grow(void *items, size_t count, size_t *capacity, size_t item_size, feeler_error *error);

/* As scene_source, without looking whether the name is there already: for the many paths of a scene without a file. */
const char *scene_add_source(feeler_scene *scene, const char *name, feeler_error *error);
/* Frees what an object owns and zeroes it. */
void scene_object_clear(scene_object *object);

#endif
