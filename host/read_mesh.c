/* read_mesh.c - the `mesh` key: a file's name, or vertices and triangles in place. */
#include "mesh.h"
#include "schema.h"
#include "vec.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

char *resolve_path(const reader *reader, const char *name) {
    const char *folder = name[0] == '/' ? "" : reader->directory;
    size_t size = strlen(folder) + strlen(name) + 1;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s%s", folder, name);
    return path;
}

/* Said here, where the scene's line is known, and not by the reader of meshes. */
static int check_mesh_file(const reader *reader, const feeler_node *node, const char *path) {
    struct stat status;
    char here[NODE_PATH_SIZE];
    place at = node_place(node_value(node), here);
    if (stat(path, &status) != 0)
        return fail_at(reader->error, FEELER_IO, at, "the mesh file '%s' cannot be opened: %s", path, strerror(errno));
    if (S_ISDIR(status.st_mode))
        return fail_at(reader->error, FEELER_IO, at, "the mesh file '%s' is a folder", path);
    return 0;
}

static int read_mesh_file(reader *reader, const feeler_node *const *nodes, int material, place place) {
    const char *name = "";
    bool smooth = false;
    for (int slot = MESH_VERTICES; slot <= MESH_NORMALS; slot++)
        if (nodes[slot])
            return fail_key(reader, nodes[slot], "a mesh has either 'file' or '%s'", nodes[slot]->key);
    if (read_text(reader, nodes[MESH_FILE], &name) != 0 ||
        (nodes[MESH_SMOOTH] && read_bool(reader, nodes[MESH_SMOOTH], &smooth) != 0))
        return -1;
    char *path = resolve_path(reader, name);
    if (!path)
        return fail_memory(reader);
    int status = check_mesh_file(reader, nodes[MESH_FILE], path);
    if (status == 0)
        status =
            scene_add_mesh_file(reader->scene, path, material, nodes[MESH_SMOOTH] ? smooth : -1, place, reader->error);
    free(path);
    return status;
}

static int check_index(const reader *reader, const feeler_node *node, size_t triangle, double index, size_t vertices) {
    if (index != floor(index))
        return fail_item(reader, node, triangle, "triangle %zu: the vertex index %.9g is not a whole number", triangle,
                         index);
    if (index < 0 || index >= (double)vertices)
        return fail_item(reader, node, triangle,
                         "triangle %zu: the vertex index %.0f is out of range; the mesh has %zu vertices, from 0",
                         triangle, index, vertices);
    return 0;
}

static int read_triangles(const reader *reader, const feeler_node *node, scene_mesh *mesh) {
    vec3 *triples = NULL;
    node = node_value(node);
    if (read_vectors(reader, node, &triples, &mesh->triangle_count) != 0)
        return -1;
    int status = 0;
    mesh->indices = malloc((mesh->triangle_count + 1) * 3 * sizeof *mesh->indices);
    if (!mesh->indices)
        status = fail_memory(reader);
    for (size_t i = 0; status == 0 && i < mesh->triangle_count; i++) {
        const double corners[3] = {triples[i].x, triples[i].y, triples[i].z};
        for (size_t j = 0; status == 0 && j < 3; j++) {
            status = check_index(reader, node, i, corners[j], mesh->vertex_count);
            if (status == 0)
                mesh->indices[3 * i + j] = (uint32_t)corners[j];
        }
    }
    free(triples);
    return status;
}

static int read_normals(const reader *reader, const feeler_node *node, scene_mesh *mesh) {
    size_t count;
    node = node_value(node);
    if (read_vectors(reader, node, &mesh->normals, &count) != 0)
        return -1;
    if (count != mesh->vertex_count)
        return fail_node(reader, node, "%zu normals for %zu vertices", count, mesh->vertex_count);
    for (size_t i = 0; i < count; i++)
        if (vec_extent(mesh->normals[i]) == 0)
            return fail_item(reader, node, i, "normal %zu has length zero", i);
    return 0;
}

static int check_vertices(const reader *reader, const feeler_node *node, const scene_mesh *mesh) {
    if (mesh->vertex_count > UINT32_MAX)
        return fail_node(reader, node, "more than %lu vertices", (unsigned long)UINT32_MAX);
    for (size_t i = 0; i < mesh->vertex_count; i++)
        if (vec_extent(mesh->vertices[i]) > MAX_COORDINATE)
            return fail_item(reader, node, i, "vertex %zu is farther out than %g", i, MAX_COORDINATE);
    return 0;
}

static int read_mesh_lists(reader *reader, const feeler_node *node, const feeler_node *const *nodes, scene_mesh *mesh) {
    static const char *const needed[] = {[MESH_VERTICES] = "vertices", [MESH_TRIANGLES] = "triangles"};
    bool smooth = nodes[MESH_NORMALS] != NULL;
    for (int slot = MESH_VERTICES; slot <= MESH_TRIANGLES; slot++)
        if (!nodes[slot])
            return fail_node(reader, node_value(node),
                             "a mesh needs 'file', or 'vertices' and 'triangles'; '%s' is missing", needed[slot]);
    if (read_vectors(reader, nodes[MESH_VERTICES], &mesh->vertices, &mesh->vertex_count) != 0 ||
        check_vertices(reader, node_value(nodes[MESH_VERTICES]), mesh) != 0 ||
        read_triangles(reader, nodes[MESH_TRIANGLES], mesh) != 0 ||
        (nodes[MESH_NORMALS] && read_normals(reader, nodes[MESH_NORMALS], mesh) != 0) ||
        (nodes[MESH_SMOOTH] && read_bool(reader, nodes[MESH_SMOOTH], &smooth) != 0))
        return -1;
    if (smooth)
        return mesh_complete_normals(mesh, reader->error);
    free(mesh->normals);
    mesh->normals = NULL;
    return 0;
}

int read_mesh(reader *reader, const feeler_node *node, int material, place place) {
    const feeler_node *nodes[MESH_SLOTS] = {NULL};
    if (schema_read(reader, node, mesh_keys, NULL, nodes) != 0)
        return -1;
    if (nodes[MESH_FILE])
        return read_mesh_file(reader, nodes, material, place);
    scene_mesh mesh = {0, 0, NULL, NULL, NULL};
    if (read_mesh_lists(reader, node, nodes, &mesh) != 0)
        goto failed;
    if (material < 0) {
        material = read_default_material(reader);
        if (material < 0)
            goto failed;
    }
    scene_object *object = scene_add_object(reader->scene, reader->error);
    if (!object)
        goto failed;
    object->shape = SHAPE_MESH;
    object->material = material;
    object->place = place;
    object->mesh = mesh;
    return 0;
failed:
    free(mesh.vertices);
    free(mesh.normals);
    free(mesh.indices);
    return -1;
}
