/* mesh_file.h - what the files mesh_*.c share: reading a mesh file through assimp. */
#ifndef FEELER_MESH_FILE_H
#define FEELER_MESH_FILE_H

#include "scene.h"

#include <stdio.h>

struct aiMaterial;

/* What is wrong with a file, and where: line and column count from 1, 0 where it is the file as a whole. */
typedef struct mesh_fault {
    int line, column;
    char text[512];
} mesh_fault;

/* mesh_check.c: what assimp does not see. FEELER_OK when the file at `path` can be opened, is no folder, is not empty, and,
 * being OBJ, PLY or STL, is whole and spells its numbers as numbers; else another feeler_code, with the reason in `fault`. */
int mesh_check_file(const char *path, mesh_fault *fault);
/* Whether the file's name ends so, whatever the case; `ending` with its dot. */
bool mesh_ends_with(const char *path, const char *ending);

/* mesh_text.c. Each returns as mesh_check_file does. */

/* Whether the text is one number, and where asked a finite one. */
int mesh_check_number(const char *text, bool finite, char *why, size_t size);
int mesh_check_obj(FILE *file, size_t length, mesh_fault *fault);
/* The text of an OBJ file, `length` bytes that become fewer or more, as assimp reads it right: without comments,
 * indentation and continuation in lines of numbers, ".5" as "0.5", "+1" as "1". assimp would leave such lines out or take
 * something else from them. To be freed; NULL: out of memory. */
char *mesh_obj_plain(FILE *file, size_t *length);
int mesh_check_stl_text(FILE *file, size_t length, mesh_fault *fault);

/* mesh_triangulate.c: cuts a planar face, convex or concave, into count - 2 triangles of the same winding. `corners` are indices
 * of vertices, at least 3, and are used up; `triangles` has room for three times count - 2. */
void mesh_triangulate(const vec3 *vertices, uint32_t *corners, size_t count, uint32_t *triangles);

/* mesh_weld.c. All work in place. */

/* Drops the normals, of length 1, where they say no more than the triangles themselves do: flat shading, and corners that can be welded. */
void mesh_drop_facet_normals(scene_mesh *mesh);
/* Makes one vertex of those with the same position and normal, bit for bit, and drops those that no triangle uses: a surface
 * that is closed in space is closed in its indices. */
int mesh_weld(scene_mesh *mesh, feeler_error *error);
void mesh_clear(scene_mesh *mesh);

/* mesh_material.c: a material of the file in terms of the model; for one that says nothing, the pale default. `clamped` gets
 * the file's keys, separated by commas, whose values were out of range. */
enum { MESH_KEYS_SIZE = 160 };
int mesh_material_set(scene_material *material, const struct aiMaterial *source, char clamped[MESH_KEYS_SIZE],
                      feeler_error *error);

#endif
