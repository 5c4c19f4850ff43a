/* mesh.c - see mesh.h. */
#include "mesh.h"
#include "vec.h"

#include <stdlib.h>

bool triangle_degenerate(vec3 a, vec3 b, vec3 c) {
    vec3 ab = vec_subtract(b, a), ac = vec_subtract(c, a), bc = vec_subtract(c, b);
    double extent = fmax(vec_extent(ab), fmax(vec_extent(ac), vec_extent(bc)));
    int exponent;
    frexp(extent, &exponent);
    ab = (vec3){ldexp(ab.x, -exponent), ldexp(ab.y, -exponent), ldexp(ab.z, -exponent)};
    ac = (vec3){ldexp(ac.x, -exponent), ldexp(ac.y, -exponent), ldexp(ac.z, -exponent)};
    /* The extent is now 0.5 to 1; rounding alone makes some 1e-16 of collinear corners' cross product. */
    return !(vec_extent(vec_cross(ab, ac)) > 1e-15);
}

static double angle_between(vec3 a, vec3 b) {
    a = vec_unit_extent(a);
    b = vec_unit_extent(b);
    return atan2(vec_length(vec_cross(a, b)), vec_dot(a, b));
}

static void add_triangle(vec3 *sums, const scene_mesh *mesh, const uint32_t *corners) {
    for (int i = 0; i < 3; i++) {
        uint32_t here = corners[i];
        vec3 next = vec_subtract(mesh->vertices[corners[(i + 1) % 3]], mesh->vertices[here]);
        vec3 last = vec_subtract(mesh->vertices[corners[(i + 2) % 3]], mesh->vertices[here]);
        vec3 normal = vec_cross(vec_unit_extent(next), vec_unit_extent(last));
        if (vec_normalize(&normal))
            sums[here] = vec_add(sums[here], vec_scale(normal, angle_between(next, last)));
    }
}

int mesh_complete_normals(scene_mesh *mesh, feeler_error *error) {
    size_t missing = 0;
    for (size_t i = 0; mesh->normals && i < mesh->vertex_count; i++)
        missing += !vec_finite(mesh->normals[i]) || vec_extent(mesh->normals[i]) == 0;
    if (mesh->normals && missing == 0)
        return 0;
    vec3 *sums = calloc(mesh->vertex_count + 1, sizeof *sums);
    if (!sums)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < mesh->triangle_count; i++)
        add_triangle(sums, mesh, mesh->indices + 3 * i);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        bool given = mesh->normals && vec_finite(mesh->normals[i]) && vec_extent(mesh->normals[i]) > 0;
        if (given)
            sums[i] = mesh->normals[i];
        else if (!vec_normalize(&sums[i]))
            sums[i] = (vec3){0, 0, 1}; /* no triangle uses it, or those around cancel */
    }
    free(mesh->normals);
    mesh->normals = sums;
    return 0;
}

size_t mesh_drop_degenerate(scene_mesh *mesh) {
    size_t kept = 0;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *from = mesh->indices + 3 * i;
        if (triangle_degenerate(mesh->vertices[from[0]], mesh->vertices[from[1]], mesh->vertices[from[2]]))
            continue;
        for (int j = 0; j < 3; j++)
            mesh->indices[3 * kept + (size_t)j] = from[j];
        kept++;
    }
    size_t dropped = mesh->triangle_count - kept;
    mesh->triangle_count = kept;
    return dropped;
}
