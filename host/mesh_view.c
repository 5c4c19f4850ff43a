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

static axes axes_for(const char *path) {
    if (mesh_ends_with(path, ".stl"))
        return (axes){{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    return (axes){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

static vec3 along(const axes *a, double right, double up, double front) {
    return vec_add(vec_scale(a->right, right), vec_add(vec_scale(a->up, up), vec_scale(a->front, front)));
}

/* How far the meshes reach, seen along the view's axes. */
typedef struct extent {
    double near, far; /* along `front` */
    double right, left, top,
        bottom; /* greatest distance to that side plus slope times nearness: what a side of the frame touches */
} extent;

static extent extent_of(const feeler_scene *scene, const axes *view, double slope_across, double slope_up) {
    extent e = {-HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < scene->object_count; i++)
        for (size_t k = 0; k < scene->objects[i].mesh.vertex_count; k++) {
            vec3 v = scene->objects[i].mesh.vertices[k];
            double x = vec_dot(v, view->right), y = vec_dot(v, view->up), z = vec_dot(v, view->front);
            e.near = fmax(e.near, z);
            e.far = fmin(e.far, z);
            e.right = fmax(e.right, slope_across * z + x);
            e.left = fmax(e.left, slope_across * z - x);
            e.top = fmax(e.top, slope_up * z + y);
            e.bottom = fmax(e.bottom, slope_up * z - y);
        }
    return e;
}

/* Where the middle of what an eye sees lies along an axis, as a slope from the eye's own `at` there. */
static double middle_seen(const feeler_scene *scene, vec3 axis, vec3 front, double at, double eye) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < scene->object_count; i++)
        for (size_t k = 0; k < scene->objects[i].mesh.vertex_count; k++) {
            vec3 v = scene->objects[i].mesh.vertices[k];
            double slope = (vec_dot(v, axis) - at) / (eye - vec_dot(v, front));
            low = fmin(low, slope);
            high = fmax(high, slope);
        }
    return (low + high) / 2;
}

/* The nearest eye from which every vertex lies within the slopes: each side of the frame is a plane that touches the meshes, and
 * two opposite ones meet at the eye's depth. Across the direction that has room to spare the eye is moved to the middle. */
static void place_eye(feeler_scene *scene, const axes *view, double slope_across, double slope_up) {
    extent e = extent_of(scene, view, slope_across, slope_up);
    double x = (e.right - e.left) / 2, y = (e.top - e.bottom) / 2, z = (e.near + e.far) / 2;
    double eye = fmax((e.right + e.left) / (2 * slope_across), (e.top + e.bottom) / (2 * slope_up));
    if (eye > e.near) {
        for (int i = 0; i < 4; i++) { /* each step leaves a fraction of the error */
            x += middle_seen(scene, view->right, view->front, x, eye) * (eye - z);
            y += middle_seen(scene, view->up, view->front, y, eye) * (eye - z);
        }
    } else {
        eye = e.near + 1; /* a single point */
    }
    scene->camera.look_at = along(view, x, y, z);
    scene->camera.eye = along(view, x, y, eye);
}

static void set_camera(feeler_scene *scene, const axes *own) {
    axes view = {.front = along(own, 0.55, 0.42, 1)};
    vec_normalize(&view.front);
    view.right = vec_cross(own->up, view.front);
    vec_normalize(&view.right);
    view.up = vec_cross(view.front, view.right);
    scene->width = 640;
    scene->height = 480;
    scene->camera.fov = 40;
    scene->camera.up = own->up;
    double margin = 1.15;
    double slope = tan(scene->camera.fov * (3.14159265358979323846 / 360)) / margin;
    place_eye(scene, &view, slope * scene->width / scene->height, slope);
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
        set_camera(scene, &own);
        status = set_lights(scene, &own, error);
    }
    if (status) {
        feeler_scene_free(scene);
        return NULL;
    }
    return scene;
}
