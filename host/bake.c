/* bake.c - objects under an affine map: see transform_object. */
#include "transform.h"
#include "vec.h"

#include <stdlib.h>

/* An affine map and what follows from it. */
typedef struct bake {
    const matrix *matrix;
    vec3 cofactors[3]; /* rows of the matrix that turns normals: inverse transpose, up to a positive factor */
    bool mirrored;
    bool similar; /* keeps shapes: rotation, mirror and one scale */
    double scale; /* if similar */
} bake;

static vec3 column(const matrix *m, int j) {
    return (vec3){m->m[0][j], m->m[1][j], m->m[2][j]};
}

static bake prepare(const matrix *m) {
    bake b = {.matrix = m};
    vec3 columns[3] = {column(m, 0), column(m, 1), column(m, 2)};
    double extent = fmax(vec_extent(columns[0]), fmax(vec_extent(columns[1]), vec_extent(columns[2])));
    int exponent;
    frexp(extent, &exponent);
    vec3 unit[3];
    for (int j = 0; j < 3; j++)
        unit[j] =
            (vec3){ldexp(columns[j].x, -exponent), ldexp(columns[j].y, -exponent), ldexp(columns[j].z, -exponent)};
    vec3 cross[3] = {vec_cross(unit[1], unit[2]), vec_cross(unit[2], unit[0]), vec_cross(unit[0], unit[1])};
    b.mirrored = vec_dot(unit[0], cross[0]) < 0;
    double sign = b.mirrored ? -1 : 1;
    b.cofactors[0] = (vec3){sign * cross[0].x, sign * cross[1].x, sign * cross[2].x};
    b.cofactors[1] = (vec3){sign * cross[0].y, sign * cross[1].y, sign * cross[2].y};
    b.cofactors[2] = (vec3){sign * cross[0].z, sign * cross[1].z, sign * cross[2].z};
    double square = vec_dot(unit[0], unit[0]);
    b.scale = ldexp(sqrt(square), exponent);
    b.similar = true;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            b.similar = b.similar && fabs(vec_dot(unit[i], unit[j]) - (i == j ? square : 0)) <= 1e-9 * square;
    return b;
}

static vec3 point(const bake *b, vec3 p) {
    return matrix_apply(b->matrix, p);
}

static vec3 normal(const bake *b, vec3 n) {
    vec3 turned = {vec_dot(b->cofactors[0], n), vec_dot(b->cofactors[1], n), vec_dot(b->cofactors[2], n)};
    vec_normalize(&turned);
    return turned;
}

static void swap_points(vec3 *a, vec3 *b) {
    vec3 spare = *a;
    *a = *b;
    *b = spare;
}

static void bake_triangle(const bake *b, scene_object *object) {
    for (int i = 0; i < 3; i++) {
        object->triangle.corners[i] = point(b, object->triangle.corners[i]);
        if (object->triangle.smooth)
            object->triangle.normals[i] = normal(b, object->triangle.normals[i]);
    }
    if (b->mirrored) {
        swap_points(&object->triangle.corners[1], &object->triangle.corners[2]);
        swap_points(&object->triangle.normals[1], &object->triangle.normals[2]);
    }
}

static void bake_polygon(const bake *b, scene_object *object) {
    vec3 *corners = object->polygon.corners;
    size_t count = object->polygon.count;
    for (size_t i = 0; i < count; i++)
        corners[i] = point(b, corners[i]);
    for (size_t i = 0; b->mirrored && i < count / 2; i++)
        swap_points(&corners[i], &corners[count - 1 - i]);
}

static void bake_mesh(const bake *b, scene_mesh *mesh) {
    for (size_t i = 0; i < mesh->vertex_count; i++)
        mesh->vertices[i] = point(b, mesh->vertices[i]);
    for (size_t i = 0; mesh->normals && i < mesh->vertex_count; i++)
        mesh->normals[i] = normal(b, mesh->normals[i]);
    for (size_t i = 0; b->mirrored && i < mesh->triangle_count; i++) {
        uint32_t spare = mesh->indices[3 * i + 1];
        mesh->indices[3 * i + 1] = mesh->indices[3 * i + 2];
        mesh->indices[3 * i + 2] = spare;
    }
}

/* Whether every axis goes to an axis, up to rounding that no coordinate would show. */
static bool keeps_axes(const matrix *m) {
    for (int j = 0; j < 3; j++) {
        double extent = vec_extent(column(m, j));
        int large = 0;
        for (int i = 0; i < 3; i++)
            large += fabs(m->m[i][j]) > 1e-14 * extent;
        if (large != 1)
            return false;
    }
    return true;
}

/* The box's corners, numbered by which of x (1), y (2), z (4) is high, and its faces seen from outside. */
static int box_to_mesh(scene_object *object, feeler_error *error) {
    static const uint32_t faces[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,  /* x low, x high */
                                       0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,  /* y */
                                       0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6}; /* z */
    vec3 low = object->box.low, high = object->box.high;
    scene_mesh mesh = {.vertex_count = 8, .triangle_count = 12};
    mesh.vertices = malloc(8 * sizeof *mesh.vertices);
    mesh.indices = malloc(sizeof faces);
    if (!mesh.vertices || !mesh.indices) {
        free(mesh.vertices);
        free(mesh.indices);
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    }
    for (int i = 0; i < 8; i++)
        mesh.vertices[i] = (vec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    for (int i = 0; i < 36; i++)
        mesh.indices[i] = faces[i];
    object->shape = SHAPE_MESH;
    object->mesh = mesh;
    return 0;
}

static int bake_box(const bake *b, scene_object *object, feeler_error *error) {
    vec3 low = object->box.low, high = object->box.high;
    if (!(low.x < high.x && low.y < high.y &&
          low.z < high.z)) /* checked here as well: afterwards it could not be seen */
        return fail_at(error, FEELER_BAD_INPUT, object->place,
                       "the box's 'low' must be below its 'high' in x, y and z");
    if (!keeps_axes(b->matrix)) {
        if (box_to_mesh(object, error) != 0)
            return -1;
        bake_mesh(b, &object->mesh);
        return 0;
    }
    vec3 p = point(b, low), q = point(b, high);
    object->box.low = (vec3){fmin(p.x, q.x), fmin(p.y, q.y), fmin(p.z, q.z)};
    object->box.high = (vec3){fmax(p.x, q.x), fmax(p.y, q.y), fmax(p.z, q.z)};
    return 0;
}

static void bake_cone(const bake *b, scene_object *object) {
    object->cone.base = point(b, object->cone.base);
    object->cone.top = point(b, object->cone.top);
    object->cone.base_radius *= b->scale;
    object->cone.top_radius *= b->scale;
}

int transform_object(const matrix *matrix, scene_object *object, feeler_error *error) {
    bake b = prepare(matrix);
    switch (object->shape) {
    case SHAPE_SPHERE:
        if (!b.similar)
            return 1;
        object->sphere.centre = point(&b, object->sphere.centre);
        object->sphere.radius *= b.scale;
        return 0;
    case SHAPE_PLANE:
        object->plane.point = point(&b, object->plane.point);
        object->plane.normal = normal(&b, object->plane.normal);
        return 0;
    case SHAPE_DISC:
        if (!b.similar)
            return 1;
        object->disc.centre = point(&b, object->disc.centre);
        object->disc.normal = normal(&b, object->disc.normal);
        object->disc.radius *= b.scale;
        return 0;
    case SHAPE_BOX:
        return bake_box(&b, object, error);
    case SHAPE_TRIANGLE:
        bake_triangle(&b, object);
        return 0;
    case SHAPE_POLYGON:
        bake_polygon(&b, object);
        return 0;
    case SHAPE_CONE:
        if (!b.similar)
            return 1;
        bake_cone(&b, object);
        return 0;
    case SHAPE_MESH:
        bake_mesh(&b, &object->mesh);
        return 0;
    case SHAPE_INSTANCE:
        object->instance.matrix = matrix_multiply(matrix, &object->instance.matrix);
        return 0;
    }
    return 0;
}
