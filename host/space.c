/* space.c - where the packed scene's origin is, the view from there, and whether a mesh encloses space. */
#include "blocks.h"
#include "transform.h"
#include "vec.h"

#include <math.h>
#include <stdlib.h>

typedef struct extent {
    vec3 low, high;
} extent;

static void include_ball(extent *e, vec3 p, double r) {
    e->low = (vec3){fmin(e->low.x, p.x - r), fmin(e->low.y, p.y - r), fmin(e->low.z, p.z - r)};
    e->high = (vec3){fmax(e->high.x, p.x + r), fmax(e->high.y, p.y + r), fmax(e->high.z, p.z + r)};
}

static void include_points(extent *e, const vec3 *points, size_t count) {
    for (size_t i = 0; i < count; i++)
        include_ball(e, points[i], 0);
}

static void include_instance(extent *e, const scene_group *group, const matrix *matrix) {
    vec3 low = group->low, high = group->high;
    if (group->object_count == 0)
        return;
    matrix_apply_to_box(matrix, &low, &high);
    include_points(e, (vec3[]){low, high}, 2);
}

static void include_object(extent *e, const scene_group *groups, const scene_object *o) {
    switch (o->shape) {
    case SHAPE_SPHERE:
        include_ball(e, o->sphere.centre, o->sphere.radius);
        break;
    case SHAPE_PLANE:
        break;
    case SHAPE_DISC:
        include_ball(e, o->disc.centre, o->disc.radius);
        break;
    case SHAPE_BOX:
        include_points(e, (vec3[]){o->box.low, o->box.high}, 2);
        break;
    case SHAPE_TRIANGLE:
        include_points(e, o->triangle.corners, 3);
        break;
    case SHAPE_POLYGON:
        include_points(e, o->polygon.corners, o->polygon.count);
        break;
    case SHAPE_CONE:
        include_ball(e, o->cone.base, o->cone.base_radius);
        include_ball(e, o->cone.top, o->cone.top_radius);
        break;
    case SHAPE_MESH:
        include_points(e, o->mesh.vertices, o->mesh.vertex_count);
        break;
    case SHAPE_INSTANCE:
        include_instance(e, &groups[o->instance.group], &o->instance.matrix);
        break;
    }
}

static const extent nowhere = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

void scene_measure_group(scene_group *group) {
    extent e = nowhere;
    for (size_t i = 0; i < group->object_count; i++)
        include_object(&e, NULL, &group->objects[i]);
    group->low = e.low;
    group->high = e.high;
}

/* A multiple of a power of two, so that moving by it rounds little and a scene scaled by a power of two moves alike. */
static double shift(double middle, double size) {
    if (!(fabs(middle) > 2 * size))
        return 0;
    if (size == 0)
        return middle;
    int exponent;
    frexp(size, &exponent);
    return ldexp(rint(ldexp(middle, -exponent)), exponent);
}

static vec3 origin_of(extent e) {
    vec3 middle = vec_add(vec_scale(e.low, 0.5), vec_scale(e.high, 0.5));
    double size = 0.5 * vec_extent(vec_subtract(e.high, e.low));
    return (vec3){shift(middle.x, size), shift(middle.y, size), shift(middle.z, size)};
}

vec3 origin_of_group(const scene_group *group) {
    return origin_of((extent){group->low, group->high});
}

vec3 scene_origin(const feeler_scene *scene) {
    extent e = nowhere;
    for (size_t i = 0; i < scene->object_count; i++)
        include_object(&e, scene->groups, &scene->objects[i]);
    if (!(e.low.x <= e.high.x)) /* nothing bounded: what the eye looks at */
        include_points(&e, (vec3[]){scene->camera.eye, scene->camera.look_at}, 2);
    return origin_of(e);
}

static real4 to_real4(vec3 v) {
    return (real4){v.x, v.y, v.z, 0};
}

view pack_view(const feeler_scene *scene, const feeler_settings *resolved, vec3 origin) {
    const scene_camera *camera = &scene->camera;
    vec3 forward = vec_subtract(camera->look_at, camera->eye);
    vec_normalize(&forward);
    vec3 right = vec_cross(forward, vec_unit_extent(camera->up));
    vec_normalize(&right);
    vec3 up = vec_cross(right, forward);
    /* Half a pixel's height at distance 1. */
    double span = camera->spans_centres ? fmax(resolved->height - 1, 1) : resolved->height;
    double half = tan(camera->fov * (acos(-1.0) / 360)) / span;
    vec3 ambient = scene->ambient;
    for (size_t i = 0; i < scene->light_count; i++)
        ambient = vec_add(ambient, scene->lights[i].ambient);
    return (view){
        .eye = to_real4(vec_subtract(camera->eye, origin)),
        .forward = to_real4(forward),
        .right = to_real4(vec_scale(right, half)),
        .up = to_real4(vec_scale(up, half)),
        .background = to_real4(scene->background),
        .ambient = to_real4(ambient),
        .limits = {resolved->cutoff, resolved->jitter, resolved->transparent, 0},
    };
}

static int compare_edges(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

int mesh_is_closed(const scene_mesh *mesh, feeler_error *error) {
    size_t count = 3 * mesh->triangle_count;
    uint64_t *edges = malloc((count ? 2 * count : 1) * sizeof *edges);
    if (!edges)
        return fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the edges of a mesh");
    uint64_t *back = edges + count;
    for (size_t i = 0; i < count; i++) {
        uint64_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = a << 32 | b;
        back[i] = b << 32 | a;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(back, count, sizeof *back, compare_edges);
    int closed = count > 0;
    for (size_t i = 0; closed && i < count; i++)
        closed = edges[i] == back[i];
    free(edges);
    return closed;
}

static bool is_inside(real4 p, bounds b) {
    return p.x >= b.low.x && p.x <= b.high.x && p.y >= b.low.y && p.y <= b.high.y && p.z >= b.low.z && p.z <= b.high.z;
}

/* Below a plane that is a half-space, or as near to it as rounding may take the eye. */
static bool is_below(real4 p, const plane *plane, bool is_double) {
    vec3 eye = {p.x, p.y, p.z}, point = {plane->point.x, plane->point.y, plane->point.z};
    vec3 normal = {plane->normal.x, plane->normal.y, plane->normal.z};
    double slack = (is_double ? 0x1p-49 : 0x1p-20) * (vec_extent(eye) + vec_extent(point));
    return vec_dot(normal, vec_subtract(eye, point)) <= slack;
}

/* Meshes have one box together; what is in an instance is in its box. */
bool eye_may_be_inside(const packed *p, real4 eye) {
    const uint4 *primitives = p->arrays[ARRAY_PRIMITIVES].data;
    const plane *planes = p->arrays[ARRAY_PLANES].data;
    bounds meshes = empty_bounds();
    for (size_t i = 0; i < p->own; i++) {
        if (!(primitives[i].w & FLAG_SOLID) && primitives[i].x != KIND_INSTANCE)
            continue;
        bounds b = primitive_bounds(p, i);
        if (primitives[i].x == KIND_TRIANGLE)
            meshes = join(meshes, b);
        else if (is_inside(eye, b) ||
                 (primitives[i].x == KIND_PLANE && is_below(eye, &planes[primitives[i].y], p->is_double)))
            return true;
    }
    return is_inside(eye, meshes);
}
