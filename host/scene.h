/* scene.h - a scene in memory, in double precision and world space: what the readers fill and what pack reads.
 *
 * Invariant after feeler_scene_validate: every number is finite and in its documented range, directions have length 1,
 * material indices are in range, no triangle is degenerate.
 */
#ifndef FEELER_SCENE_H
#define FEELER_SCENE_H

#include "feeler.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct vec3 {
    double x, y, z;
} vec3;

/* Where something was written, for errors: a file's name or a key's path (interned in the scene), line and column. */
typedef struct place {
    const char *source; /* NULL: unknown */
    int line, column;
} place;

/* Symbols are those of the model (16.20, 16.12). Reflectances are 0 … 1, emission 0 … 1e6. */
typedef struct scene_material {
    char *name;                 /* owned; may be NULL */
    vec3 ambient;               /* c_a */
    vec3 diffuse;               /* c_d */
    vec3 specular;              /* c_s */
    vec3 diffuse_transmission;  /* c_td */
    vec3 specular_transmission; /* c_ts */
    vec3 emission;              /* I_e */
    vec3 reflection;            /* rho_rg */
    vec3 transmission;          /* rho_tg */
    double shininess;           /* f, 0 < f <= 1e6 */
    double ior;                 /* refractive index, 0.1 … 10 */
    double priority;            /* of the medium; the highest counts, equal ones by order of entry */
    bool total_reflection;      /* extension: on total internal reflection the reflection carries rho_rg + rho_tg */
    bool fresnel;               /* extension: Fresnel weights */
    place place;
} scene_material;

typedef struct scene_light {
    bool directional;
    vec3 position; /* of a point light; of a directional one, the unit vector towards it */
    vec3 ambient;  /* I_a,i */
    vec3 diffuse;  /* I_d,i */
    vec3 specular; /* I_s,i */
    place place;
} scene_light;

/* The upper three rows of a 4 x 4 matrix whose last is 0 0 0 1; it multiplies column vectors from the left. */
typedef struct matrix {
    double m[3][4];
} matrix;

typedef enum shape {
    SHAPE_SPHERE,
    SHAPE_PLANE,
    SHAPE_DISC,
    SHAPE_BOX,
    SHAPE_TRIANGLE,
    SHAPE_POLYGON,
    SHAPE_CONE,
    SHAPE_MESH,
    SHAPE_INSTANCE
} shape;

enum { BOTH_SIDES, FRONT_ONLY, BACK_ONLY }; /* which side of a surface is seen; the front is where the normal points */

typedef struct scene_mesh {
    size_t vertex_count, triangle_count;
    vec3 *vertices;    /* owned */
    vec3 *normals;     /* owned, one per vertex, unit length; NULL: flat */
    uint32_t *indices; /* owned, three per triangle, counter-clockwise from the front */
} scene_mesh;

typedef struct scene_object {
    shape shape;
    int sides;
    int material; /* index into the scene's materials; of an instance -1: those inside keep their own */
    int number;   /* of the file's object that this is, or is a part of */
    place place;
    union {
        struct {
            vec3 centre;
            double radius;
        } sphere;
        struct {
            vec3 point, normal;
        } plane; /* unit normal; behind it is inside */
        struct {
            vec3 centre, normal;
            double radius;
        } disc;
        struct {
            vec3 low, high;
        } box; /* axis-aligned; a turned box is loaded as a mesh */
        struct {
            vec3 corners[3], normals[3];
            bool smooth;
        } triangle;
        struct {
            vec3 *corners;
            size_t count;
        } polygon; /* owned; planar; counter-clockwise from the front */
        struct {
            vec3 base, top;
            double base_radius, top_radius;
            bool capped;
        } cone; /* a cylinder has equal radii */
        scene_mesh mesh;
        struct {
            int group;
            matrix matrix; /* from the group's space to the world; has an inverse */
        } instance;
    };
} scene_object;

/* Objects that instances place, in a space of their own. There are no planes and no instances among them. */
typedef struct scene_group {
    scene_object *objects; /* owned */
    size_t object_count;
    vec3 low, high; /* a box around them all, when validated */
} scene_group;

typedef struct scene_camera {
    vec3 eye, look_at, up;
    double fov;         /* vertical, degrees, 0 < fov < 180 */
    bool spans_centres; /* NFF: the angle spans the first to the last pixel's centres */
    place place;
} scene_camera;

struct feeler_scene {
    char *name; /* file name without folder and ending; owned */
    scene_camera camera;
    int width, height, samples;
    double jitter;
    vec3 background, ambient;
    int depth;
    double cutoff;
    bool shadows, filtered_shadows, smooth_terminator;
    scene_light *lights;
    size_t light_count, light_capacity;
    scene_material *materials;
    size_t material_count, material_capacity;
    scene_object *objects;
    size_t object_count, object_capacity;
    scene_group *groups;
    size_t group_count, group_capacity;
    char **warnings;
    size_t warning_count, warning_capacity;
    char **sources; /* interned names for `place` */
    size_t source_count, source_capacity;
    size_t dropped_triangles;
    double load_seconds;
};

/* A scene with every default, no objects, no lights, no materials. NULL: out of memory. */
feeler_scene *scene_new(feeler_error *error);
/* Each appends a zeroed element (materials: with the defaults) and returns it, valid until the next append. */
scene_object *scene_add_object(feeler_scene *scene, feeler_error *error);
scene_group *scene_add_group(feeler_scene *scene, feeler_error *error);
scene_light *scene_add_light(feeler_scene *scene, feeler_error *error);
scene_material *scene_add_material(feeler_scene *scene, feeler_error *error);
/* The interned copy of a source name; NULL: out of memory. */
const char *scene_source(feeler_scene *scene, const char *name, feeler_error *error);
/* Appends "source:line:column: text", without what the place does not know. -1: out of memory. */
int scene_warn(feeler_scene *scene, place place, feeler_error *error, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Checks every range, normalises directions, drops degenerate triangles with a warning. */
int scene_validate(feeler_scene *scene, feeler_error *error);

/* Sets the group's box. */
void scene_measure_group(scene_group *group);

/* Readers, chosen by feeler_scene_load. Each returns a scene that is not yet validated. */
feeler_scene *scene_read_yaml(const char *path, feeler_error *error);
feeler_scene *scene_read_nff(const char *path, feeler_error *error);
/* Reads a bare mesh file and gives it a camera that frames it, a light and a material. */
feeler_scene *scene_read_mesh(const char *path, feeler_error *error);

/* Loads a mesh file through assimp and appends its meshes as objects of the scene (and its materials, when `material` is
 * negative). `smooth`: 1 keep the file's normals or make smooth ones, 0 flat, -1 the file's normals if it has them. */
int scene_add_mesh_file(feeler_scene *scene, const char *path, int material, int smooth, place place,
                        feeler_error *error);

/* error.c: fills the error if it is still empty; returns -1 so that `return fail(…)` reads well. */
int fail(feeler_error *error, int code, const char *format, ...) __attribute__((format(printf, 3, 4)));
int fail_at(feeler_error *error, int code, place place, const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
