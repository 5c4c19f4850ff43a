/* pack.c - the only writer of the device's structs. */
#include "packed.h"

#include "vec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const array empty_arrays[ARRAY_COUNT] = {
    [ARRAY_PRIMITIVES] = {.name = "primitives", .element = sizeof(uint4)},
    [ARRAY_SPHERES] = {.name = "spheres", .element = sizeof(sphere), .is_real = true},
    [ARRAY_PLANES] = {.name = "planes", .element = sizeof(plane), .is_real = true},
    [ARRAY_DISCS] = {.name = "discs", .element = sizeof(disc), .is_real = true},
    [ARRAY_BOXES] = {.name = "boxes", .element = sizeof(box), .is_real = true},
    [ARRAY_TRIANGLES] = {.name = "triangles", .element = sizeof(uint4)},
    [ARRAY_VERTICES] = {.name = "vertices", .element = sizeof(real4), .is_real = true},
    [ARRAY_NORMALS] = {.name = "normals", .element = sizeof(real4), .is_real = true},
    [ARRAY_POLYGONS] = {.name = "polygons", .element = sizeof(polygon), .is_real = true},
    [ARRAY_POLYGON_RANGES] = {.name = "polygon_ranges", .element = sizeof(uint4)},
    [ARRAY_CORNERS] = {.name = "corners", .is_real = true}, /* rows of the width */
    [ARRAY_CONES] = {.name = "cones", .element = sizeof(cone), .is_real = true},
    [ARRAY_INSTANCES] = {.name = "instances", .element = sizeof(instance), .is_real = true},
    [ARRAY_INSTANCE_ROOTS] = {.name = "instance_roots", .element = sizeof(uint4)},
    [ARRAY_NODES] = {.name = "nodes", .is_real = true},
    [ARRAY_LINKS] = {.name = "links", .element = 2 * sizeof(uint32_t)},
    [ARRAY_BLOCKS] = {.name = "blocks", .is_real = true},
    [ARRAY_BLOCK_NUMBERS] = {.name = "block_numbers", .element = sizeof(uint32_t)},
    [ARRAY_MATERIALS] = {.name = "materials", .element = sizeof(material), .is_real = true},
    [ARRAY_LIGHTS] = {.name = "lights", .element = sizeof(light), .is_real = true},
};

double rounded(const packed *p, double x) {
    return p->is_double ? x : (double)(float)x;
}

real4 pack4(const packed *p, vec3 v, double w) {
    return (real4){rounded(p, v.x), rounded(p, v.y), rounded(p, v.z), rounded(p, w)};
}

static real4 pack_point(const packed *p, vec3 v, double w) {
    return pack4(p, vec_subtract(v, p->origin), w);
}

static vec3 xyz(real4 v) {
    return (vec3){v.x, v.y, v.z};
}

/* Relative to its own size and place, so that a scaled scene's box is the scaled box. */
bounds pack_bounds(const packed *p, vec3 low, vec3 high) {
    double unit = p->is_double ? 0x1p-51 : 0x1p-22;
    vec3 size = vec_subtract(high, low);
    double extent = vec_extent(size);
    vec3 pad = {unit * (extent + fmax(fabs(low.x), fabs(high.x))), unit * (extent + fmax(fabs(low.y), fabs(high.y))),
                unit * (extent + fmax(fabs(low.z), fabs(high.z)))};
    return (bounds){pack4(p, vec_subtract(low, pad), 0), pack4(p, vec_add(high, pad), 0)};
}

static uint32_t side_flags(int sides) {
    return sides == FRONT_ONLY ? FLAG_BACK_HIDDEN : sides == BACK_ONLY ? FLAG_FRONT_HIDDEN : 0;
}

/* Appends to `kind`'s array and to the primitives; returns the place of the new element. */
static void *add_primitive(packed *p, packed_array where, uint32_t kind, const scene_object *object, uint32_t flags,
                           feeler_error *error) {
    uint4 *primitive = array_add(&p->arrays[ARRAY_PRIMITIVES], 1, error);
    void *element = primitive ? array_add(&p->arrays[where], 1, error) : NULL;
    if (element)
        *primitive = (uint4){kind, (uint32_t)p->arrays[where].count - 1, (uint32_t)object->material,
                             flags | side_flags(object->sides)};
    return element;
}

static int pack_sphere(packed *p, const scene_object *object, feeler_error *error) {
    sphere *s = add_primitive(p, ARRAY_SPHERES, KIND_SPHERE, object, FLAG_SOLID, error);
    if (!s)
        return -1;
    s->centre_radius = pack_point(p, object->sphere.centre, object->sphere.radius);
    vec3 centre = xyz(s->centre_radius), r = {s->centre_radius.w, s->centre_radius.w, s->centre_radius.w};
    s->bounds = pack_bounds(p, vec_subtract(centre, r), vec_add(centre, r));
    return 0;
}

/* Of a plane's points the one nearest to the origin: coordinates that are 0 stay 0. */
static int pack_plane(packed *p, const scene_object *object, feeler_error *error) {
    plane *s = add_primitive(p, ARRAY_PLANES, KIND_PLANE, object, FLAG_SOLID, error);
    if (!s)
        return -1;
    vec3 normal = object->plane.normal;
    double height = vec_dot(normal, vec_subtract(object->plane.point, p->origin));
    s->point = pack4(p, vec_scale(normal, height), 0);
    s->normal = pack4(p, normal, 0);
    return 0;
}

/* How far a disc of radius r with this unit normal reaches along each axis. */
static vec3 disc_reach(vec3 n, double r) {
    return (vec3){r * hypot(n.y, n.z), r * hypot(n.z, n.x), r * hypot(n.x, n.y)};
}

static int pack_disc(packed *p, const scene_object *object, feeler_error *error) {
    disc *s = add_primitive(p, ARRAY_DISCS, KIND_DISC, object, 0, error);
    if (!s)
        return -1;
    s->centre_radius = pack_point(p, object->disc.centre, object->disc.radius);
    s->normal = pack4(p, object->disc.normal, 0);
    vec3 reach = disc_reach(object->disc.normal, s->centre_radius.w), centre = xyz(s->centre_radius);
    s->bounds = pack_bounds(p, vec_subtract(centre, reach), vec_add(centre, reach));
    return 0;
}

/* The box is its own bounds and gets no slack. */
static int pack_box(packed *p, const scene_object *object, feeler_error *error) {
    box *s = add_primitive(p, ARRAY_BOXES, KIND_BOX, object, FLAG_SOLID, error);
    if (!s)
        return -1;
    s->bounds = (bounds){pack_point(p, object->box.low, 0), pack_point(p, object->box.high, 0)};
    return 0;
}

static int pack_vertices(packed *p, const vec3 *vertices, const vec3 *normals, size_t count, feeler_error *error) {
    real4 *v = array_add(&p->arrays[ARRAY_VERTICES], count, error);
    if (!v)
        return -1;
    for (size_t i = 0; i < count; i++)
        v[i] = pack_point(p, vertices[i], 0);
    if (!normals)
        return 0;
    /* Normals are found by the vertex's index: fill up for those without. */
    array *all = &p->arrays[ARRAY_NORMALS];
    size_t missing = p->arrays[ARRAY_VERTICES].count - all->count;
    real4 *n = array_add(all, missing, error);
    if (!n)
        return -1;
    n += missing - count;
    for (size_t i = 0; i < count; i++)
        n[i] = pack4(p, normals[i], 0);
    return 0;
}

static int pack_triangles(packed *p, const scene_object *object, const scene_mesh *mesh, uint32_t flags,
                          feeler_error *error) {
    size_t first = p->arrays[ARRAY_VERTICES].count;
    uint4 *primitives = array_add(&p->arrays[ARRAY_PRIMITIVES], mesh->triangle_count, error);
    uint4 *triangles = primitives ? array_add(&p->arrays[ARRAY_TRIANGLES], mesh->triangle_count, error) : NULL;
    if (!triangles || pack_vertices(p, mesh->vertices, mesh->normals, mesh->vertex_count, error) < 0)
        return -1;
    flags |= side_flags(object->sides) | (mesh->normals ? FLAG_SMOOTH : 0);
    size_t number = p->arrays[ARRAY_TRIANGLES].count - mesh->triangle_count;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->indices + 3 * i;
        primitives[i] = (uint4){KIND_TRIANGLE, (uint32_t)(number + i), (uint32_t)object->material, flags};
        triangles[i] =
            (uint4){(uint32_t)(first + corner[0]), (uint32_t)(first + corner[1]), (uint32_t)(first + corner[2]), 0};
    }
    return 0;
}

static int pack_triangle(packed *p, const scene_object *object, feeler_error *error) {
    static uint32_t indices[3] = {0, 1, 2};
    scene_mesh mesh = {.vertex_count = 3, .triangle_count = 1, .indices = indices};
    mesh.vertices = (vec3 *)object->triangle.corners;
    mesh.normals = object->triangle.smooth ? (vec3 *)object->triangle.normals : NULL;
    return pack_triangles(p, object, &mesh, 0, error);
}

static int pack_mesh(packed *p, const scene_object *object, bool transmits, feeler_error *error) {
    int closed = transmits ? mesh_is_closed(&object->mesh, error) : 0;
    return closed < 0 ? -1 : pack_triangles(p, object, &object->mesh, closed ? FLAG_SOLID : 0, error);
}

/* Three rows of corners as kernels/polygon.cl reads them. */
typedef struct {
    real *rows;
    size_t length;
} corners;

static vec3 corner_at(corners c, size_t i) {
    return (vec3){c.rows[i + 1], c.rows[c.length + i + 1], c.rows[2 * c.length + i + 1]};
}

/* The last corner is in front of the first, too, and fills the rest. */
static void fill_corners(const packed *p, corners c, const vec3 *from, size_t count) {
    for (size_t i = 0; i < c.length; i++) {
        real4 corner = pack_point(p, from[i == 0 || i > count ? count - 1 : i - 1], 0);
        c.rows[i] = corner.x;
        c.rows[c.length + i] = corner.y;
        c.rows[2 * c.length + i] = corner.z;
    }
}

/* The normal of a planar polygon, counter-clockwise from its front, by Newell's sum about its middle; lengths are scaled
 * by a power of two first, so that their products stay in range. */
static vec3 polygon_normal(corners c, size_t count, vec3 middle, double size) {
    int exponent;
    frexp(size, &exponent);
    double unit = ldexp(1, -exponent);
    vec3 sum = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        vec3 a = vec_scale(vec_subtract(corner_at(c, i), middle), unit);
        vec3 b = vec_scale(vec_subtract(corner_at(c, (i + 1) % count), middle), unit);
        sum = vec_add(sum, vec_cross(a, b));
    }
    vec_normalize(&sum);
    return sum;
}

static int pack_polygon(packed *p, const scene_object *object, feeler_error *error) {
    size_t count = object->polygon.count, length = (count + p->width - 1) / p->width * p->width + 1;
    size_t units = (3 * length + p->width - 1) / p->width;
    polygon *s = add_primitive(p, ARRAY_POLYGONS, KIND_POLYGON, object, 0, error);
    uint4 *range = s ? array_add(&p->arrays[ARRAY_POLYGON_RANGES], 1, error) : NULL;
    corners c = {range ? array_add(&p->arrays[ARRAY_CORNERS], units, error) : NULL, length};
    if (!c.rows)
        return -1;
    *range = (uint4){(uint32_t)(p->arrays[ARRAY_CORNERS].count - units), (uint32_t)count, 0, 0};
    fill_corners(p, c, object->polygon.corners, count);
    vec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY}, middle = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        vec3 v = corner_at(c, i);
        low = (vec3){fmin(low.x, v.x), fmin(low.y, v.y), fmin(low.z, v.z)};
        high = (vec3){fmax(high.x, v.x), fmax(high.y, v.y), fmax(high.z, v.z)};
        middle = vec_add(middle, vec_scale(v, 1 / (double)count));
    }
    s->point = pack4(p, middle, 0);
    s->normal = pack4(p, polygon_normal(c, count, middle, vec_extent(vec_subtract(high, low))), 0);
    s->bounds = pack_bounds(p, low, high);
    return 0;
}

/* Two unit vectors that make a right-handed frame with the unit vector n (Duff et al. 2017). */
static void make_frame(vec3 n, vec3 *u, vec3 *v) {
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    *u = (vec3){1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    *v = (vec3){b, sign + n.y * n.y * a, -n.y};
}

static int pack_cone(packed *p, const scene_object *object, feeler_error *error) {
    bool capped = object->cone.capped;
    cone *s = add_primitive(p, ARRAY_CONES, KIND_CONE, object, capped ? FLAG_SOLID | FLAG_CAPPED : 0, error);
    if (!s)
        return -1;
    vec3 axis = vec_subtract(object->cone.top, object->cone.base), u, v;
    double height = vec_length(axis);
    vec_normalize(&axis);
    make_frame(axis, &u, &v);
    double slope = (object->cone.top_radius - object->cone.base_radius) / height;
    s->base_radius = pack_point(p, object->cone.base, object->cone.base_radius);
    s->u_height = pack4(p, u, height);
    s->v_slope = pack4(p, v, slope);
    s->axis = pack4(p, axis, 0);
    vec3 base = xyz(s->base_radius), top = vec_add(base, vec_scale(axis, height));
    vec3 a = disc_reach(axis, object->cone.base_radius), b = disc_reach(axis, object->cone.top_radius);
    vec3 low = {fmin(base.x - a.x, top.x - b.x), fmin(base.y - a.y, top.y - b.y), fmin(base.z - a.z, top.z - b.z)};
    vec3 high = {fmax(base.x + a.x, top.x + b.x), fmax(base.y + a.y, top.y + b.y), fmax(base.z + a.z, top.z + b.z)};
    s->bounds = pack_bounds(p, low, high);
    return 0;
}

/* A place for it: what it is takes the groups, see instances.c. */
static int pack_instance(packed *p, const scene_object *object, feeler_error *error) {
    instance *s = add_primitive(p, ARRAY_INSTANCES, KIND_INSTANCE, object, 0, error);
    return s && array_add(&p->arrays[ARRAY_INSTANCE_ROOTS], 1, error) ? 0 : -1;
}

int pack_object(packed *p, const scene_object *object, bool transmits, feeler_error *error) {
    switch (object->shape) {
    case SHAPE_SPHERE:
        return pack_sphere(p, object, error);
    case SHAPE_PLANE:
        return pack_plane(p, object, error);
    case SHAPE_DISC:
        return pack_disc(p, object, error);
    case SHAPE_BOX:
        return pack_box(p, object, error);
    case SHAPE_TRIANGLE:
        return pack_triangle(p, object, error);
    case SHAPE_POLYGON:
        return pack_polygon(p, object, error);
    case SHAPE_CONE:
        return pack_cone(p, object, error);
    case SHAPE_MESH:
        return pack_mesh(p, object, transmits, error);
    case SHAPE_INSTANCE:
        return pack_instance(p, object, error);
    }
    return fail(error, FEELER_BAD_INPUT, "an object of unknown shape");
}

static int pack_materials(packed *p, const feeler_scene *scene, feeler_error *error) {
    material *out = array_add(&p->arrays[ARRAY_MATERIALS], scene->material_count, error);
    if (!out)
        return -1;
    for (size_t i = 0; i < scene->material_count; i++) {
        const scene_material *m = &scene->materials[i];
        out[i] = (material){
            .ambient = pack4(p, m->ambient, 0),
            .diffuse = pack4(p, m->diffuse, 0),
            .specular_shininess = pack4(p, m->specular, m->shininess),
            .diffuse_transmission = pack4(p, m->diffuse_transmission, 0),
            .specular_transmission = pack4(p, m->specular_transmission, 0),
            .emission = pack4(p, m->emission, 0),
            .reflection = pack4(p, m->reflection, 0),
            .transmission = pack4(p, m->transmission, 0),
            .optics = pack4(p, (vec3){m->ior, m->priority, m->total_reflection}, m->fresnel),
        };
    }
    return 0;
}

static int pack_lights(packed *p, const feeler_scene *scene, feeler_error *error) {
    light *out = array_add(&p->arrays[ARRAY_LIGHTS], scene->light_count, error);
    if (!out)
        return -1;
    for (size_t i = 0; i < scene->light_count; i++) {
        const scene_light *l = &scene->lights[i];
        out[i].position = l->directional ? pack4(p, l->position, 0) : pack_point(p, l->position, 1);
        out[i].diffuse = pack4(p, l->diffuse, 0);
        out[i].specular = pack4(p, l->specular, 0);
    }
    return 0;
}

int packed_object_number(const packed *p, uint32_t primitive) {
    size_t low = 0, high = p->object_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(p->objects[middle].first <= primitive ? &low : &high) = middle;
    }
    return p->objects[low].number;
}

static int reserve_objects(packed *p, const feeler_scene *scene, feeler_error *error) {
    p->objects = malloc((scene->object_count + 1) * sizeof *p->objects);
    return p->objects ? 0 : fail(error, FEELER_OUT_OF_MEMORY, "out of memory for the objects' numbers");
}

static int pack_objects(packed *p, const feeler_scene *scene, feeler_error *error) {
    for (size_t i = 0; i < scene->object_count; i++) {
        const scene_object *object = &scene->objects[i];
        bool transmits = object->material >= 0 && !is_black(scene->materials[object->material].transmission);
        if (object->shape == SHAPE_INSTANCE && scene->groups[object->instance.group].object_count == 0)
            continue; /* all of it was degenerate */
        if (p->objects)
            p->objects[p->object_count++] =
                (packed_object){(uint32_t)p->arrays[ARRAY_PRIMITIVES].count, object->number};
        if (pack_object(p, object, transmits, error) < 0)
            return -1;
    }
    p->own = p->arrays[ARRAY_PRIMITIVES].count;
    return 0;
}

int pack_scene(packed *p, const feeler_scene *scene, const feeler_settings *settings, needs needs,
               feeler_error *error) {
    memset(p, 0, sizeof *p);
    memcpy(p->arrays, empty_arrays, sizeof empty_arrays);
    p->width = (size_t)needs.width;
    p->arrays[ARRAY_CORNERS].element = p->arrays[ARRAY_BLOCKS].element = p->width * sizeof(real);
    p->arrays[ARRAY_NODES].element = NODE_ROWS * p->width * sizeof(real);
    p->is_double = settings->level == FEELER_REFERENCE;
    p->origin = scene_origin(scene);
    int status = pack_materials(p, scene, error);
    if (status == 0)
        status = pack_lights(p, scene, error);
    if (status == 0 && settings->channels & FEELER_OBJECT)
        status = reserve_objects(p, scene, error);
    status = status == 0 ? pack_objects(p, scene, error) : -1;
    if (status == 0)
        status = pack_groups(p, scene, error);
    if (status == 0)
        status = build_trees(p, settings->brute_force, error);
    if (status < 0)
        packed_free(p);
    return status;
}

void packed_free(packed *p) {
    for (int i = 0; i < ARRAY_COUNT; i++) {
        free(p->arrays[i].data);
        p->arrays[i].data = NULL;
    }
    free(p->groups);
    free(p->objects);
    p->groups = NULL;
    p->objects = NULL;
}
