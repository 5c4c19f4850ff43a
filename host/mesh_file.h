/* mesh_file.h - what the files mesh_*.c share: reading a mesh file through assimp. */
#ifndef FEELER_MESH_FILE_H
#define FEELER_MESH_FILE_H

#include "scene.h"

struct aiMaterial;

/* mesh_check.c: what assimp does not see. FEELER_OK when the file at `path` can be opened, is no folder, is not empty, and,
 * being PLY or STL, is whole; else another feeler_code, with the reason in `why`. */
int mesh_check_file(const char *path, char *why, size_t size);
/* Whether the file's name ends so, whatever the case; `ending` with its dot. */
bool mesh_ends_with(const char *path, const char *ending);

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

/* mesh_material.c: a material of the file in terms of the model; for one that says nothing, the pale default. */
int mesh_material_set(scene_material *material, const struct aiMaterial *source, feeler_error *error);

#endif
