/* mesh_file.c - meshes and their materials from files, through assimp. */
#include "mesh_file.h"
#include "mesh.h"
#include "mesh_io.h"
#include "vec.h"

#include <assimp/cimport.h>
#include <assimp/scene.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One file on its way into a scene. */
typedef struct import {
    feeler_scene *scene;
    const char *path;
    int material, smooth; /* as scene_add_mesh_file takes them */
    place place;          /* of the objects and of errors */
    bool referenced;      /* the place is in another file, which errors then have to tell */
    const struct aiScene *file;
    int *materials;              /* per material of the file: the scene's index, or -1 */
    size_t triangles, leftovers; /* found so far; leftovers are points and lines */
    bool colours;
    mesh_io io;
    feeler_error *error;
} import;

static int refuse(import *in, int code, const char *format, ...) __attribute__((format(printf, 3, 4)));

static int refuse(import *in, int code, const char *format, ...) {
    char what[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (in->referenced)
        return fail_at(in->error, code, in->place, "mesh '%s': %s", in->path, what);
    return fail_at(in->error, code, in->place, "%s", what);
}

static int warn(import *in, const char *format, ...) __attribute__((format(printf, 2, 3)));

static int warn(import *in, const char *format, ...) {
    char what[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (in->referenced)
        return scene_warn(in->scene, in->place, in->error, "mesh '%s': %s", in->path, what);
    return scene_warn(in->scene, in->place, in->error, "%s", what);
}

/* ---- reading ---- */

/* assimp keeps its last error in one place for all threads. */
static pthread_mutex_t assimp_lock = PTHREAD_MUTEX_INITIALIZER;

/* assimp's words on one line. */
static void copy_reason(char *why, size_t size) {
    size_t length = 0;
    for (const char *c = aiGetErrorString(); *c && length + 1 < size; c++)
        why[length++] = (unsigned char)*c < ' ' || *c == 127 ? ' ' : *c;
    while (length && why[length - 1] == ' ')
        length--;
    why[length] = 0;
}

static const char *ending_of(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot : "";
}

static int read_file(import *in) {
    char why[512] = "";
    mesh_fault fault = {0};
    const char *ending = ending_of(in->path);
    int code = mesh_check_file(in->path, &fault);
    if (code != FEELER_OK && fault.line)
        return fail_at(in->error, code, (place){in->path, fault.line, fault.column}, "%s", fault.text);
    if (code != FEELER_OK)
        return refuse(in, code, "%s", fault.text);
    if (!ending[0] || !ending[1])
        return refuse(in, FEELER_BAD_INPUT, "the file's name has no ending that tells its format");
    if (!aiIsExtensionSupported(ending))
        return refuse(in, FEELER_BAD_INPUT, "'%s' is not a known mesh format", ending);
    pthread_mutex_lock(&assimp_lock);
    mesh_io_start(&in->io);
    in->file = aiImportFileEx(in->path, 0, &in->io.calls);
    if (!in->file)
        copy_reason(why, sizeof why);
    pthread_mutex_unlock(&assimp_lock);
    if (in->io.out_of_memory)
        return fail(in->error, FEELER_OUT_OF_MEMORY, "out of memory");
    if (in->file)
        return 0;
    if (strncmp(why, "No suitable reader", 18) == 0)
        return refuse(in, FEELER_BAD_INPUT, "does not contain what its ending '%s' promises, or is cut short", ending);
    return refuse(in, FEELER_BAD_INPUT, "cannot be read: %s", why[0] ? why : "for a reason that assimp does not tell");
}

/* Readers pass on what the file says. */
static int check_indices(import *in) {
    for (unsigned m = 0; m < in->file->mNumMeshes; m++) {
        const struct aiMesh *mesh = in->file->mMeshes[m];
        for (unsigned f = 0; f < mesh->mNumFaces; f++)
            for (unsigned k = 0; k < mesh->mFaces[f].mNumIndices; k++)
                if (mesh->mFaces[f].mIndices[k] >= mesh->mNumVertices)
                    return refuse(in, FEELER_BAD_INPUT, "face %u uses vertex %u of %u (counted from 0)", f,
                                  mesh->mFaces[f].mIndices[k], mesh->mNumVertices);
    }
    return 0;
}

/* ---- meshes ---- */

/* An affine transform, row by row. */
typedef struct transform {
    double row[3][4];
} transform;

static transform then(const transform *outer, const struct aiMatrix4x4 *m) {
    const double inner[4][4] = {
        {m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}, {0, 0, 0, 1}};
    transform both;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += outer->row[i][k] * inner[k][j];
            both.row[i][j] = sum;
        }
    return both;
}

static vec3 row_of(const transform *t, int i) {
    return (vec3){t->row[i][0], t->row[i][1], t->row[i][2]};
}

static vec3 to_point(const transform *t, const struct aiVector3D *v) {
    vec3 p = {v->x, v->y, v->z};
    return (vec3){vec_dot(row_of(t, 0), p) + t->row[0][3], vec_dot(row_of(t, 1), p) + t->row[1][3],
                  vec_dot(row_of(t, 2), p) + t->row[2][3]};
}

/* Normals go with the matrix of cofactors, the inverse transpose but for a factor. It turns them round with a mirrored
 * winding's, so that `mirrored` turns them back. */
static vec3 to_normal(const transform *t, const struct aiVector3D *v, bool mirrored) {
    vec3 n = {v->x, v->y, v->z};
    vec3 x = row_of(t, 0), y = row_of(t, 1), z = row_of(t, 2);
    vec3 turned = {vec_dot(vec_cross(y, z), n), vec_dot(vec_cross(z, x), n), vec_dot(vec_cross(x, y), n)};
    vec_normalize(&turned); /* zero and infinity stay, to be replaced */
    return mirrored ? vec_scale(turned, -1) : turned;
}

static bool is_mirrored(const transform *t) {
    return vec_dot(row_of(t, 0), vec_cross(row_of(t, 1), row_of(t, 2))) < 0;
}

static int copy_vertices(import *in, const struct aiMesh *from, const transform *t, scene_mesh *to) {
    bool mirrored = is_mirrored(t);
    /* STL's normals repeat its facets', often wrongly. */
    bool shaded = from->mNormals && in->smooth != 0 && !mesh_ends_with(in->path, ".stl");
    to->vertex_count = from->mNumVertices;
    to->vertices = malloc((to->vertex_count + 1) * sizeof *to->vertices);
    if (shaded)
        to->normals = malloc((to->vertex_count + 1) * sizeof *to->normals);
    if (!to->vertices || (shaded && !to->normals))
        return fail(in->error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < to->vertex_count; i++) {
        to->vertices[i] = to_point(t, &from->mVertices[i]);
        if (!vec_finite(to->vertices[i]))
            return refuse(in, FEELER_BAD_INPUT, "vertex %zu (counted from 0) is not finite", i);
        if (shaded)
            to->normals[i] = to_normal(t, &from->mNormals[i], mirrored);
    }
    return 0;
}

static void turn_over(scene_mesh *mesh) {
    for (size_t i = 0; i < 3 * mesh->triangle_count; i += 3) {
        uint32_t second = mesh->indices[i + 1];
        mesh->indices[i + 1] = mesh->indices[i + 2];
        mesh->indices[i + 2] = second;
    }
}

/* How many triangles the faces make, and how many corners the largest face has. */
static size_t count_triangles(import *in, const struct aiMesh *from, size_t *most_corners) {
    size_t count = 0;
    *most_corners = 3;
    for (unsigned f = 0; f < from->mNumFaces; f++) {
        size_t corners = from->mFaces[f].mNumIndices;
        if (corners < 3)
            in->leftovers++;
        else
            count += corners - 2;
        if (corners > *most_corners)
            *most_corners = corners;
    }
    return count;
}

static int copy_triangles(import *in, const struct aiMesh *from, const transform *t, scene_mesh *to) {
    size_t most_corners, count = count_triangles(in, from, &most_corners);
    uint32_t *corners = malloc(most_corners * sizeof *corners);
    uint32_t *next = to->indices = malloc((3 * count + 1) * sizeof *to->indices);
    if (!corners || !next) {
        free(corners);
        return fail(in->error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    for (unsigned f = 0; f < from->mNumFaces; f++) {
        const struct aiFace *face = &from->mFaces[f];
        if (face->mNumIndices < 3)
            continue;
        for (unsigned k = 0; k < face->mNumIndices; k++)
            corners[k] = face->mIndices[k];
        mesh_triangulate(to->vertices, corners, face->mNumIndices, next);
        next += 3 * ((size_t)face->mNumIndices - 2);
    }
    free(corners);
    to->triangle_count = count;
    if (is_mirrored(t))
        turn_over(to);
    return 0;
}

static int copy_mesh(import *in, const struct aiMesh *from, const transform *t, scene_mesh *to) {
    if (copy_vertices(in, from, t, to) || copy_triangles(in, from, t, to))
        return -1;
    if (to->normals && mesh_complete_normals(to, in->error))
        return -1;
    if (to->normals)
        mesh_drop_facet_normals(to);
    if (mesh_weld(to, in->error))
        return -1;
    return in->smooth == 1 && !to->normals ? mesh_complete_normals(to, in->error) : 0;
}

static int material_index(import *in, unsigned index) {
    if (in->material >= 0)
        return in->material;
    if (in->materials[index] >= 0)
        return in->materials[index];
    char clamped[MESH_KEYS_SIZE];
    scene_material *material = scene_add_material(in->scene, in->error);
    if (!material ||
        mesh_material_set(material, in->file->mNumMaterials ? in->file->mMaterials[index] : NULL, clamped, in->error))
        return -1;
    material->place = in->place;
    in->materials[index] = (int)(in->scene->material_count - 1);
    if (clamped[0] && warn(in, "material '%.60s': clamped to what a scene may hold: %s",
                           material->name ? material->name : "", clamped))
        return -1;
    return in->materials[index];
}

static int add_mesh(import *in, const struct aiMesh *from, const transform *t) {
    scene_mesh mesh = {0};
    int material = -1;
    scene_object *object = NULL;
    if (copy_mesh(in, from, t, &mesh))
        goto done;
    in->colours |= from->mColors[0] != NULL;
    in->triangles += mesh.triangle_count;
    if (mesh.triangle_count == 0) {
        mesh_clear(&mesh);
        return 0;
    }
    material = material_index(in, in->file->mNumMaterials ? from->mMaterialIndex : 0);
    if (material >= 0)
        object = scene_add_object(in->scene, in->error);
done:
    if (!object) {
        mesh_clear(&mesh);
        return -1;
    }
    object->shape = SHAPE_MESH;
    object->sides = BOTH_SIDES;
    object->material = material;
    object->place = in->place;
    object->mesh = mesh;
    return 0;
}

static int add_node(import *in, const struct aiNode *node, const transform *outer) {
    transform t = then(outer, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        if (add_mesh(in, in->file->mMeshes[node->mMeshes[i]], &t))
            return -1;
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (add_node(in, node->mChildren[i], &t))
            return -1;
    return 0;
}

/* ---- the file as a whole ---- */

static bool has_textures(const import *in) {
    for (unsigned i = 0; i < in->file->mNumMaterials; i++)
        for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; type++)
            if (aiGetMaterialTextureCount(in->file->mMaterials[i], (enum aiTextureType)type))
                return true;
    return false;
}

static int warn_of_all(import *in) {
    if (in->leftovers && warn(in, "%zu faces that are points or lines are left out", in->leftovers))
        return -1;
    if (in->material >= 0)
        return 0;
    if (in->io.missing[0] && warn(in, "the materials in '%s' cannot be opened", in->io.missing))
        return -1;
    if (in->colours && warn(in, "colours of vertices are not used"))
        return -1;
    return has_textures(in) ? warn(in, "textures are not used") : 0;
}

static int add_file(import *in) {
    static const transform identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    if (check_indices(in))
        return -1;
    size_t count = in->file->mNumMaterials ? in->file->mNumMaterials : 1;
    in->materials = malloc(count * sizeof *in->materials);
    if (!in->materials)
        return fail(in->error, FEELER_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < count; i++)
        in->materials[i] = -1;
    if (in->file->mRootNode && add_node(in, in->file->mRootNode, &identity))
        return -1;
    if (in->triangles == 0)
        return refuse(in, FEELER_BAD_INPUT, "contains no triangles");
    return warn_of_all(in);
}

int scene_add_mesh_file(feeler_scene *scene, const char *path, int material, int smooth, place place,
                        feeler_error *error) {
import in = {.scene = scene, .path = path, .material = material, .smooth = smooth, .place = place, .error = error };
    in.referenced = place.source != NULL;
    if (!in.referenced)
        in.place.source = scene_source(scene, path, error);
    if (!in.place.source)
        return -1;
    int status = read_file(&in);
    if (status == 0)
        status = add_file(&in);
    if (in.file)
        aiReleaseImport(in.file);
    mesh_io_end(&in.io);
    free(in.materials);
    return status;
}
