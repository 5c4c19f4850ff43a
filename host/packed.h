/* packed.h - a scene as the device sees it: arrays in the kernels' layout, and the features that it needs.
 *
 * Packing works in double; for a float kernel every number is rounded to float as it is written, so that bounds are those
 * of the rounded geometry and narrowing the arrays afterwards loses nothing. Coordinates are relative to `origin`.
 */
#ifndef FEELER_PACKED_H
#define FEELER_PACKED_H

#include "array.h"
#include "scene.h"
#include "types.h"

/* In the order of the kernels' parameters. */
typedef enum packed_array {
    ARRAY_PRIMITIVES,
    ARRAY_SPHERES,
    ARRAY_PLANES,
    ARRAY_DISCS,
    ARRAY_BOXES,
    ARRAY_TRIANGLES,
    ARRAY_VERTICES,
    ARRAY_NORMALS,
    ARRAY_POLYGONS,
    ARRAY_POLYGON_RANGES,
    ARRAY_CORNERS,
    ARRAY_CONES,
    ARRAY_INSTANCES,
    ARRAY_INSTANCE_ROOTS,
    ARRAY_NODES,
    ARRAY_LINKS,
    ARRAY_BLOCKS,
    ARRAY_BLOCK_NUMBERS,
    ARRAY_MATERIALS,
    ARRAY_LIGHTS,
    ARRAY_COUNT
} packed_array;

/* What a scene may need: the kernels' HAS_…, by these names. */
typedef enum feature {
    FEATURE_SPHERE,
    FEATURE_PLANE,
    FEATURE_DISC,
    FEATURE_BOX,
    FEATURE_TRIANGLE,
    FEATURE_POLYGON,
    FEATURE_CONE,
    FEATURE_INSTANCE,
    FEATURE_SMOOTH,
    FEATURE_ONE_SIDED,
    FEATURE_DIFFUSE,
    FEATURE_SPECULAR,
    FEATURE_DIFFUSE_TRANSMISSION,
    FEATURE_SPECULAR_TRANSMISSION,
    FEATURE_REFLECTION,
    FEATURE_TRANSMISSION,
    FEATURE_PRIORITY,
    FEATURE_FRESNEL,
    FEATURE_TOTAL_REFLECTION,
    FEATURE_SHADOWS,
    FEATURE_FILTERED_SHADOWS,
    FEATURE_TERMINATOR,
    FEATURE_LIGHTS,
    FEATURE_TREE,
    FEATURE_COUNT
} feature;

extern const char *const feature_names[FEATURE_COUNT];
extern const uint32_t all_features;

/* Their names with a space between, in this order; `size` has room for all. */
void features_text(uint32_t features, char *text, size_t size);

/* What a kernel is built for. */
typedef struct needs {
    uint32_t features; /* bit i: feature i */
    int media;         /* length of a ray's list of media */
    int width;         /* children of a node, and primitives of a block */
    bool notes;        /* of all that a pixel's rays do */
} needs;

/* kernels/media.cl keeps a list per ray; nothing seen in practice nests deeper. */
enum { MOST_MEDIA = 8 };

/* What the scene needs, or with settings->general everything that the settings do not forbid. */
needs choose_needs(const feeler_scene *scene, const feeler_settings *settings);

/* A group's primitives, which come after the scene's own, and what is over them. */
typedef struct packed_group {
    size_t first, count;
    vec3 origin;        /* of their coordinates, in the group's */
    uint32_t root, end; /* its root's node and the next, or without a tree its links */
} packed_group;

/* An object's first primitive, and its number in the scene. */
typedef struct packed_object {
    uint32_t first;
    int number;
} packed_object;

typedef struct packed {
    array arrays[ARRAY_COUNT];
    bool is_double;
    size_t width; /* as in needs */
    vec3 origin;  /* of the packed coordinates, in the scene's */
    size_t own;   /* primitives that are not a group's */
    packed_group *groups;
    size_t group_count;
    packed_object *objects; /* in the order of their primitives, if the settings ask for the channel */
    size_t object_count;
    size_t own_blocks, planes; /* blocks of the scene's own primitives; the numbers of its planes come after theirs */
    size_t blocks;
    bool eye_inside; /* the eye may be in a medium: see eye_may_be_inside */
    double tree_seconds;
} packed;

/* Reads a validated scene for resolved settings and their needs. */
int pack_scene(packed *packed, const feeler_scene *scene, const feeler_settings *settings, needs needs,
               feeler_error *error);
void packed_free(packed *packed);
/* The number of the object whose primitive this is. */
int packed_object_number(const packed *packed, uint32_t primitive);

bool is_black(vec3 colour);

/* Where a scene's coordinates are moved to: the middle of what is bounded, if that is far from 0 for its size. */
vec3 scene_origin(const feeler_scene *scene);

/* The same for a group's coordinates in its own space. */
vec3 origin_of_group(const scene_group *group);

/* pack.c, for instances.c: a number or vector as the device will have it, and an object's primitives. `transmits`: whether it
 * may bound a medium. */
double rounded(const packed *packed, double x);
real4 pack4(const packed *packed, vec3 v, double w);
/* A box around [low, high], wider by what rounding may have taken. */
bounds pack_bounds(const packed *packed, vec3 low, vec3 high);
int pack_object(packed *packed, const scene_object *object, bool transmits, feeler_error *error);

/* instances.c: packs the groups that are used, and finishes the scene's instances, which are the first `own` primitives'. */
int pack_groups(packed *packed, const feeler_scene *scene, feeler_error *error);

/* The box of the primitive with this number, as the device computes it. */
bounds primitive_bounds(const packed *packed, size_t number);

/* Puts bounded primitives into blocks, and a tree over them, one for the scene and one for each group: fills nodes, links,
 * blocks and block numbers. */
int build_trees(packed *packed, bool brute_force, feeler_error *error);

/* Whether the eye, in packed coordinates, is in the box of a solid. Else it is in no medium. */
bool eye_may_be_inside(const packed *packed, real4 eye);

/* The view of a scene for a picture of width x height pixels, as `real` of the packed kind. */
view pack_view(const feeler_scene *scene, const feeler_settings *resolved, vec3 origin);

/* Whether every edge of the mesh is shared by two triangles in opposite directions; -1: out of memory. */
int mesh_is_closed(const scene_mesh *mesh, feeler_error *error);

#endif
