/* mesh_view.c - a bare mesh file as a scene: a camera that frames it, two lights, a plain background.
 *
 * The view is from the front, right and above. Up is +Y, as modelling programs and scans have it; for STL, which comes from
 * construction and printing, up is +Z and the front is -Y.
 */
#include "mesh_file.h"
#include "vec.h"

/* The scene's own axes. */
typedef struct axes {
    vec3 right, up, front; /* front points from the object to the viewer */
} axes;

typedef struct bounds {
    vec3 low, high;
} bounds;

static axes axes_for(const char *path) {
    if (mesh_ends_with(path, ".stl"))
        return (axes){{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    return (axes){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

static vec3 along(const axes *a, double right, double up, double front) {
    return vec_add(vec_scale(a->right, right), vec_add(vec_scale(a->up, up), vec_scale(a->front, front)));
}

static bounds bounds_of(const feeler_scene *scene) {
    bounds b = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (size_t i = 0; i < scene->object_count; i++) {
        const scene_mesh *mesh = &scene->objects[i].mesh;
        for (size_t k = 0; k < mesh->vertex_count; k++) {
            vec3 v = mesh->vertices[k];
            b.low = (vec3){fmin(b.low.x, v.x), fmin(b.low.y, v.y), fmin(b.low.z, v.z)};
            b.high = (vec3){fmax(b.high.x, v.x), fmax(b.high.y, v.y), fmax(b.high.z, v.z)};
        }
    }
    return b;
}

/* How far from the middle of the box an eye has to be for all its corners to be in the picture. */
static double framing_distance(const feeler_scene *scene, const bounds *b, const axes *view) {
    double slope = tan(scene->camera.fov * (3.14159265358979323846 / 360));
    double aspect = (double)scene->width / scene->height;
    vec3 half = vec_scale(vec_subtract(b->high, b->low), 0.5);
    double distance = 0;
    for (int i = 0; i < 8; i++) {
        vec3 corner = {i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
        double nearness = vec_dot(corner, view->front);
        distance = fmax(distance, nearness + fabs(vec_dot(corner, view->up)) / slope);
        distance = fmax(distance, nearness + fabs(vec_dot(corner, view->right)) / (slope * aspect));
    }
    return distance;
}

static void set_camera(feeler_scene *scene, const bounds *b, const axes *own) {
    axes view = {.front = along(own, 0.55, 0.42, 1)};
    vec_normalize(&view.front);
    view.right = vec_cross(own->up, view.front);
    vec_normalize(&view.right);
    view.up = vec_cross(view.front, view.right);
    scene->width = 640;
    scene->height = 480;
    scene->camera.fov = 40;
    scene->camera.up = own->up;
    scene->camera.look_at = vec_scale(vec_add(b->low, b->high), 0.5);
    double margin = 1.08;
    double distance = margin * framing_distance(scene, b, &view);
    if (!(distance > 0))
        distance = 1;
    scene->camera.eye = vec_add(scene->camera.look_at, vec_scale(view.front, distance));
}

static int add_light(feeler_scene *scene, vec3 position, double diffuse, double specular, feeler_error *error) {
    scene_light *light = scene_add_light(scene, error);
    if (!light)
        return -1;
    light->position = position;
    light->diffuse = (vec3){diffuse, diffuse, diffuse};
    light->specular = (vec3){specular, specular, specular};
    return 0;
}

/* The key light stands behind the camera, above on its left; a weak one on its right fills the shadows. */
static int set_lights(feeler_scene *scene, const axes *own, feeler_error *error) {
    vec3 centre = scene->camera.look_at, eye = scene->camera.eye;
    double distance = vec_length(vec_subtract(eye, centre));
    scene->background = (vec3){0.42, 0.52, 0.64};
    scene->ambient = (vec3){0.16, 0.17, 0.19};
    if (add_light(scene, vec_add(eye, along(own, -1.4 * distance, 1.2 * distance, 0.2 * distance)), 0.85, 1, error))
        return -1;
    return add_light(scene, vec_add(eye, along(own, 1.2 * distance, 0.1 * distance, -0.2 * distance)), 0.22, 0, error);
}

feeler_scene *scene_read_mesh(const char *path, feeler_error *error) {
    feeler_scene *scene = scene_new(error);
    if (!scene)
        return NULL;
    axes own = axes_for(path);
    int status = scene_add_mesh_file(scene, path, -1, -1, (place){0}, error);
    if (status == 0) {
        bounds b = bounds_of(scene);
        set_camera(scene, &b, &own);
        status = set_lights(scene, &own, error);
    }
    if (status) {
        feeler_scene_free(scene);
        return NULL;
    }
    return scene;
}
