/* describe_scene.c - a loaded scene as JSON: what the readers made of a file, number by number. For the tests only. */
#include "scene.h"

#include <stdio.h>

static void print_vec3(const char *key, vec3 v, const char *end) {
    printf("\"%s\": [%.17g, %.17g, %.17g]%s", key, v.x, v.y, v.z, end);
}

static void print_list(const char *key, const vec3 *items, size_t count) {
    printf(", \"%s\": [", key);
    for (size_t i = 0; i < count; i++)
        printf("%s[%.17g, %.17g, %.17g]", i ? ", " : "", items[i].x, items[i].y, items[i].z);
    printf("]");
}

static void print_material(const scene_material *m) {
    printf("{\"name\": \"%s\", ", m->name ? m->name : "");
    print_vec3("ambient", m->ambient, ", ");
    print_vec3("diffuse", m->diffuse, ", ");
    print_vec3("specular", m->specular, ", ");
    print_vec3("diffuse_transmission", m->diffuse_transmission, ", ");
    print_vec3("specular_transmission", m->specular_transmission, ", ");
    print_vec3("emission", m->emission, ", ");
    print_vec3("reflection", m->reflection, ", ");
    print_vec3("transmission", m->transmission, ", ");
    printf("\"shininess\": %.17g, \"ior\": %.17g}", m->shininess, m->ior);
}

static void print_light(const scene_light *l) {
    printf("{");
    print_vec3("position", l->position, ", ");
    print_vec3("ambient", l->ambient, ", ");
    print_vec3("diffuse", l->diffuse, ", ");
    print_vec3("specular", l->specular, "}");
}

static void print_mesh(const scene_mesh *m) {
    print_list("vertices", m->vertices, m->vertex_count);
    print_list("normals", m->normals, m->normals ? m->vertex_count : 0);
    printf(", \"triangles\": [");
    for (size_t i = 0; i < m->triangle_count; i++)
        printf("%s[%u, %u, %u]", i ? ", " : "", m->indices[3 * i], m->indices[3 * i + 1], m->indices[3 * i + 2]);
    printf("]");
}

static void print_object(const scene_object *o) {
    static const char *const shapes[] = {"sphere", "plane", "disc", "box", "triangle", "polygon", "cone", "mesh"};
    static const char *const sides[] = {"both", "front", "back"};
    printf("{\"shape\": \"%s\", \"sides\": \"%s\", \"material\": %d, \"line\": %d", shapes[o->shape], sides[o->sides], o->material,
           o->place.line);
    if (o->shape == SHAPE_SPHERE) {
        print_list("centre", &o->sphere.centre, 1);
        printf(", \"radius\": %.17g", o->sphere.radius);
    } else if (o->shape == SHAPE_CONE) {
        print_list("base", &o->cone.base, 1);
        print_list("top", &o->cone.top, 1);
        printf(", \"radii\": [%.17g, %.17g], \"capped\": %s", o->cone.base_radius, o->cone.top_radius,
               o->cone.capped ? "true" : "false");
    } else if (o->shape == SHAPE_TRIANGLE) {
        print_list("corners", o->triangle.corners, 3);
        print_list("normals", o->triangle.normals, o->triangle.smooth ? 3 : 0);
    } else if (o->shape == SHAPE_POLYGON) {
        print_list("corners", o->polygon.corners, o->polygon.count);
    } else if (o->shape == SHAPE_MESH) {
        print_mesh(&o->mesh);
    }
    printf("}");
}

#define PRINT_ALL(key, items, count, print) \
    do { \
        printf(",\n\"%s\": [", key); \
        for (size_t i = 0; i < (count); i++) { \
            printf("%s\n", i ? "," : ""); \
            print(&(items)[i]); \
        } \
        printf("]"); \
    } while (0)

static void print_scene(const feeler_scene *s) {
    printf("{\"size\": [%d, %d], \"depth\": %d, \"fov\": %.17g, \"spans_centres\": %s, ", s->width, s->height, s->depth,
           s->camera.fov, s->camera.spans_centres ? "true" : "false");
    print_vec3("eye", s->camera.eye, ", ");
    print_vec3("look_at", s->camera.look_at, ", ");
    print_vec3("up", s->camera.up, ", ");
    print_vec3("background", s->background, "");
    PRINT_ALL("lights", s->lights, s->light_count, print_light);
    PRINT_ALL("materials", s->materials, s->material_count, print_material);
    PRINT_ALL("objects", s->objects, s->object_count, print_object);
    printf(",\n\"warnings\": [");
    for (size_t i = 0; i < s->warning_count; i++)
        printf("%s\"%s\"", i ? ", " : "", s->warnings[i]);
    printf("]}\n");
}

int main(int argc, char **argv) {
    feeler_error error = {0};
    char text[sizeof error.source + sizeof error.text + 64];
    feeler_scene *scene = argc == 2 ? feeler_scene_load(argv[1], &error) : NULL;
    if (!scene) {
        feeler_error_format(&error, text, sizeof text);
        fprintf(stderr, "%s\n", text);
        return 1;
    }
    print_scene(scene);
    feeler_scene_free(scene);
    return 0;
}
