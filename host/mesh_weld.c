/* mesh_weld.c - equal vertices made one, and normals that say nothing dropped. */
#include "mesh_file.h"
#include "vec.h"

#include <stdlib.h>
#include <string.h>

void mesh_clear(scene_mesh *mesh) {
    free(mesh->vertices);
    free(mesh->normals);
    free(mesh->indices);
    *mesh = (scene_mesh){0};
}

/* ---- welding ---- */

static const uint32_t nothing = UINT32_MAX;

static uint64_t mix(uint64_t hash, vec3 v) {
    const double values[3] = {v.x + 0.0, v.y + 0.0, v.z + 0.0}; /* -0 equals 0 and has to hash like it */
    uint64_t bits[3];
    memcpy(bits, values, sizeof bits);
    for (int i = 0; i < 3; i++) {
        hash = (hash ^ bits[i]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return hash;
}

static bool equal(vec3 a, vec3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* A hash table of kept vertices, open addressing; a power of two slots. */
typedef struct weld {
    const scene_mesh *from;
    scene_mesh to;   /* vertices and normals with room for all */
    uint32_t *known; /* per vertex of `from`: its index in `to`, or nothing while no triangle has used it */
    uint32_t *slots; /* an index into `to`, or nothing */
    size_t slot_count;
} weld;

static uint32_t kept_vertex(weld *w, uint32_t index) {
    vec3 vertex = w->from->vertices[index];
    vec3 normal = w->from->normals ? w->from->normals[index] : (vec3){0, 0, 0};
    size_t slot = mix(mix(0, vertex), normal) & (w->slot_count - 1);
    for (; w->slots[slot] != nothing; slot = (slot + 1) & (w->slot_count - 1)) {
        uint32_t kept = w->slots[slot];
        if (equal(w->to.vertices[kept], vertex) && (!w->to.normals || equal(w->to.normals[kept], normal)))
            return kept;
    }
    uint32_t kept = w->slots[slot] = (uint32_t)w->to.vertex_count++;
    w->to.vertices[kept] = vertex;
    if (w->to.normals)
        w->to.normals[kept] = normal;
    return kept;
}

static vec3 *shrunk(vec3 *items, size_t count) {
    vec3 *smaller = realloc(items, (count ? count : 1) * sizeof *items);
    return smaller ? smaller : items;
}

/* False when out of memory; what there is is to be freed either way. */
static bool make_room(weld *w) {
    const size_t count = w->from->vertex_count;
    while (w->slot_count < 2 * count)
        w->slot_count *= 2;
    w->known = malloc((count + 1) * sizeof *w->known);
    w->slots = malloc(w->slot_count * sizeof *w->slots);
    w->to.vertices = malloc((count + 1) * sizeof *w->to.vertices);
    if (w->from->normals)
        w->to.normals = malloc((count + 1) * sizeof *w->to.normals);
    if (!w->known || !w->slots || !w->to.vertices || (w->from->normals && !w->to.normals))
        return false;
    memset(w->known, 0xff, count * sizeof *w->known);
    memset(w->slots, 0xff, w->slot_count * sizeof *w->slots);
    return true;
}

int mesh_weld(scene_mesh *mesh, feeler_error *error) {
    weld w = {.from = mesh, .slot_count = 16};
    const bool room = make_room(&w);
    for (size_t i = 0; room && i < 3 * mesh->triangle_count; i++) {
        uint32_t *known = &w.known[mesh->indices[i]];
        if (*known == nothing)
            *known = kept_vertex(&w, mesh->indices[i]);
        mesh->indices[i] = *known;
    }
    free(w.known);
    free(w.slots);
    if (!room) {
        mesh_clear(&w.to);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    free(mesh->vertices);
    free(mesh->normals);
    mesh->vertex_count = w.to.vertex_count;
    mesh->vertices = shrunk(w.to.vertices, mesh->vertex_count);
    mesh->normals = w.to.normals ? shrunk(w.to.normals, mesh->vertex_count) : NULL;
    return 0;
}

/* ---- normals ---- */

/* The unit normal of a triangle; false where it has none. */
static bool facet_normal(const scene_mesh *mesh, const uint32_t *corner, vec3 *normal) {
    vec3 a = mesh->vertices[corner[0]];
    vec3 p = vec_subtract(mesh->vertices[corner[1]], a), q = vec_subtract(mesh->vertices[corner[2]], a);
    return vec_normalize(&p) && vec_normalize(&q) && (*normal = vec_cross(p, q), vec_normalize(normal));
}

void mesh_drop_facet_normals(scene_mesh *mesh) {
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->indices + 3 * i;
        vec3 facet;
        if (!facet_normal(mesh, corner, &facet))
            continue;
        for (int k = 0; k < 3; k++) { /* within 0.0001 radians: as near as printed normals come */
            vec3 off = vec_subtract(mesh->normals[corner[k]], facet);
            if (!(vec_dot(off, off) < 1e-8))
                return;
        }
    }
    free(mesh->normals);
    mesh->normals = NULL;
}
