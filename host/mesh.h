/* mesh.h - what can be said of, and done to, triangles before they are packed. */
#ifndef FEELER_MESH_H
#define FEELER_MESH_H

#include "scene.h"

/* Whether the corners span no area that double precision could tell from none; the same at every scale by 2^k. */
bool triangle_degenerate(vec3 a, vec3 b, vec3 c);
/* Sets the normals of those vertices that have none (zero or not finite), or of all where the mesh has no normals yet: the
 * mean of the triangles around, weighted by their angles. -1: out of memory. Indices must be in range. */
int mesh_complete_normals(scene_mesh *mesh, feeler_error *error);
/* Takes degenerate triangles out. Returns how many there were. */
size_t mesh_drop_degenerate(scene_mesh *mesh);

#endif
